//! From edges on the pin to the bit rate, on a model of TIM2 with its interrupt: what the first frame
//! is worth, and what is lost with an edge.

use canbaud::units::{Bitrate, Hertz};
use canbaud::wire::Logic;
use canbaud_capture_queue::CaptureQueue;
use canbaud_stm32f4::{Capture, Measured, Measurement, Registers};
use std::cell::RefCell;
use std::rc::Rc;

const CR1: usize = 0x00;
const DIER: usize = 0x0C;
const SR: usize = 0x10;
const EGR: usize = 0x14;
const CCMR1: usize = 0x18;
const CCER: usize = 0x20;
const CNT: usize = 0x24;
const CCR: [usize; 2] = [0x34, 0x38];

/// TIM2 as RM0090 has it, as far as it is used: channel 1 captures falling edges, channel 2 rising ones.
#[derive(Debug, Clone, Default)]
struct Tim2(Rc<RefCell<State>>);

#[derive(Debug, Default)]
struct State {
    now: u64,
    /// When the counter was 0.
    zero: u64,
    control: u32,
    interrupts: u32,
    status: u32,
    mode: u32,
    channels: u32,
    captured: [u32; 2],
}

impl State {
    fn counter(&self) -> u32 {
        if self.control & 1 == 1 { (self.now - self.zero) as u32 } else { 0 }
    }
}

impl Tim2 {
    fn edge(&self, at: u64, level: Logic) {
        let mut state = self.0.borrow_mut();
        assert!(state.now <= at, "time goes on");
        state.now = at;
        let channel = usize::from(level == Logic::High);
        if state.channels >> (4 * channel) & 1 == 0 {
            return;
        }
        if state.status >> (1 + channel) & 1 == 1 {
            state.status |= 1 << (9 + channel);
        }
        state.status |= 1 << (1 + channel);
        state.captured[channel] = state.counter();
    }

    fn wants_interrupt(&self) -> bool {
        let state = self.0.borrow();
        state.status & state.interrupts != 0
    }
}

impl Registers for Tim2 {
    fn read(&self, offset: usize) -> u32 {
        let mut state = self.0.borrow_mut();
        match (offset, CCR.iter().position(|&register| register == offset)) {
            (SR, _) => state.status,
            (CNT, _) => state.counter(),
            (_, Some(channel)) => {
                state.status &= !(1 << (1 + channel));
                state.captured[channel]
            }
            _ => panic!("{offset:#04x} is read"),
        }
    }

    fn write(&mut self, offset: usize, value: u32) {
        let mut state = self.0.borrow_mut();
        match offset {
            CR1 => {
                state.zero = if state.control & 1 == 0 { state.now } else { state.zero };
                state.control = value;
            }
            DIER => state.interrupts = value,
            // Bits are cleared by 0, and not set by 1.
            SR => state.status &= value,
            EGR => state.zero = state.now,
            CCMR1 => {
                assert!(state.channels & 0x11 == 0, "CC1S and CC2S keep what they are");
                state.mode = value;
            }
            CCER => {
                assert!(value == 0 || state.mode & 0x303 == 0x201, "both channels on TI1");
                assert!(value == 0 || value & 0xBB == 0x13, "falling in channel 1, rising in 2");
                state.channels = value;
            }
            _ => {}
        }
    }
}

/// Frames of `vectors/bits`, and the three bits between frames.
const FRAME: &str = "0011010101010000010100000100000111000100110111111111111111";
const OTHER: &str = "011101101011000001011111011110001011010001111111111111111";
/// 500 kbit/s at 16 MHz.
const BIT: u64 = 32;
/// More than both frames need.
const ROOM: usize = 128;

/// Their ticks, and the levels behind them.
type Edges = Vec<(u64, Logic)>;

struct Board<const N: usize> {
    timer: Tim2,
    queue: CaptureQueue<N>,
    measurement: Measurement,
}

impl<const N: usize> Board<N> {
    fn start() -> Self {
        let (timer, queue) = (Tim2::default(), CaptureQueue::new());
        let measurement = start(&timer, &queue);
        Self { timer, queue, measurement }
    }

    fn again(&mut self) {
        self.measurement = start(&self.timer, &self.queue);
    }

    fn interrupt(&self) {
        if self.timer.wants_interrupt() {
            Capture::new(self.timer.clone()).interrupt(&self.queue);
        }
    }

    /// An edge, with its interrupt; the main loop does not look.
    fn capture(&self, (at, level): (u64, Logic)) {
        self.timer.edge(at, level);
        self.interrupt();
    }

    fn look(&mut self) -> Measured {
        self.measurement.turn(&self.queue)
    }

    /// All in time; whether a rate was found at the last edge, and not before.
    fn find_at_the_last(&mut self, edges: &[(u64, Logic)], seed: &str) -> Measured {
        let (&last, before) = edges.split_last().expect("edges");
        for &edge in before {
            self.capture(edge);
            assert_eq!(self.look(), Measured::NotYet, "{seed}: too early");
        }
        self.capture(last);
        self.look()
    }
}

fn start<const N: usize>(timer: &Tim2, queue: &CaptureQueue<N>) -> Measurement {
    let clock = Hertz::new(16_000_000).expect("a frequency");
    let measurement = Measurement::start(&mut Capture::new(timer.clone()), queue, clock);
    // The interrupt may have been pending when it was masked: it comes, and finds nothing.
    Capture::new(timer.clone()).interrupt(queue);
    measurement
}

fn rate(bits_per_second: u32) -> Measured {
    Measured::Rate(Bitrate::new(bits_per_second).expect("a rate"))
}

/// The edges of `bits` from `begin` on, where the line is recessive; and when they are over.
fn edges(bits: &str, begin: u64, bit: u64) -> (Edges, u64) {
    let mut level = Logic::High;
    let mut edges = Vec::new();
    for (at, text) in (begin..).step_by(bit as usize).zip(bits.chars()) {
        let here = if text == '1' { Logic::High } else { Logic::Low };
        if here != level {
            edges.push((at, here));
        }
        level = here;
    }
    (edges, begin + bit * bits.len() as u64)
}

/// Two frames with an idle before, and the edge that ends the gap behind them.
fn two_frames() -> (Edges, Edges) {
    let (first, end) = edges(FRAME, 20 * BIT, BIT);
    let (mut second, end) = edges(OTHER, end, BIT);
    second.push((end, Logic::Low));
    (first, second)
}

/// Any number of edges is captured before the main loop looks for the first time: the first frame is
/// found all the same.
#[test]
fn edges_before_the_first_look_are_taken_as_they_came() {
    let (first, second) = two_frames();
    for early in 0..first.len() {
        let mut board = Board::<ROOM>::start();
        first[..early].iter().for_each(|&edge| board.capture(edge));
        let rest = [&first[early..], &second[..1]].concat();
        let found = board.find_at_the_last(&rest, &format!("{early} early"));
        assert_eq!(found, rate(500_000), "{early} early");
    }
}

#[test]
fn a_start_within_a_frame_finds_the_next() {
    let (first, second) = two_frames();
    for missed in 1..first.len() {
        let mut board = Board::<ROOM>::start();
        let (at, level) = first[missed - 1];
        board.timer.edge(at, level);
        board.again();
        let rest = [&first[missed..], &second].concat();
        let found = board.find_at_the_last(&rest, &format!("{missed} missed"));
        assert_eq!(found, rate(500_000), "{missed} missed");
    }
}

/// The interrupt is late by three to six edges, so that capture registers are overwritten; wherever it
/// is within a frame, the next one is found.
#[test]
fn a_late_interrupt_costs_one_frame() {
    let (first, second) = two_frames();
    for late in 3..=6 {
        for from in 0..=first.len() - late {
            let seed = format!("{late} edges at once from {from}");
            let mut board = Board::<ROOM>::start();
            for &edge in &first[..from] {
                board.capture(edge);
                board.look();
            }
            first[from..from + late].iter().for_each(|&(at, level)| board.timer.edge(at, level));
            board.interrupt();
            assert_eq!(board.look(), Measured::NotYet, "{seed}");
            let rest = [&first[from + late..], &second].concat();
            assert_eq!(board.find_at_the_last(&rest, &seed), rate(500_000), "{seed}");
        }
    }
}

/// The timer does not say so: the polarity does, or what remains is no frame.
#[test]
fn edges_that_were_never_captured_cost_one_frame() {
    let (first, second) = two_frames();
    for missing in 1..=3 {
        // With the last edge of the frame, the gap before the next one would be missing, too.
        for from in 0..first.len() - missing {
            let seed = format!("{missing} missing from {from}");
            let mut board = Board::<ROOM>::start();
            let rest = [&first[..from], &first[from + missing..], &second].concat();
            assert_eq!(board.find_at_the_last(&rest, &seed), rate(500_000), "{seed}");
        }
    }
}

/// The main loop is away for longer than a frame, and the queue has no room for it.
#[test]
fn a_queue_that_runs_over_costs_one_frame() {
    let (first, second) = two_frames();
    assert!(first.len() > 16);
    for away in 17..first.len() + 8 {
        let mut board = Board::<16>::start();
        let edges = [&first[..], &second].concat();
        let (early, rest) = edges.split_at(away);
        early.iter().for_each(|&edge| board.capture(edge));
        assert_eq!(board.look(), Measured::NotYet, "away for {away} edges");
        let found = board.find_at_the_last(rest, &format!("away for {away} edges"));
        assert_eq!(found, rate(500_000), "away for {away} edges");
    }
}

/// What was found was not confirmed: edges wait in the queue and in the timer, the counter begins anew,
/// and the bus has another rate by now.
#[test]
fn a_second_pass_begins_with_nothing_of_the_first() {
    let (first, second) = two_frames();
    for in_queue in 0..8 {
        for in_timer in 0..4 {
            let seed = format!("{in_queue} in the queue, {in_timer} in the timer");
            let mut board = Board::<ROOM>::start();
            let found = board.find_at_the_last(&[&first[..], &second[..1]].concat(), &seed);
            assert_eq!(found, rate(500_000), "{seed}");
            let (queued, behind) = second[1..].split_at(in_queue);
            queued.iter().for_each(|&edge| board.capture(edge));
            behind[..in_timer].iter().for_each(|&(at, level)| board.timer.edge(at, level));
            // The line becomes recessive while nothing is captured.
            let end = second.last().expect("edges").0;
            board.timer.0.borrow_mut().now = end;
            board.again();
            let (slow, end) = edges(FRAME, end + 40 * BIT, 2 * BIT);
            let slow = [slow, vec![(end, Logic::Low)]].concat();
            assert_eq!(board.find_at_the_last(&slow, &seed), rate(250_000), "{seed}");
        }
    }
}
