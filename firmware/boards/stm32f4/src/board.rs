//! The program for the board.

use canbaud::detect::scan::{Candidates, Controller, Driver, Outcome, Progress, Scan, Settings};
use canbaud::units::{Bitrate, Hertz, Micros};
use canbaud_capture_queue::CaptureQueue;
use canbaud_stm32f4::{Block, Bxcan, Capture, Measured, Measurement, Registers};
use core::panic::PanicInfo;
use core::sync::atomic::{AtomicU32, Ordering};
use cortex_m::asm::wfi;
use cortex_m::peripheral::NVIC;
use cortex_m_rt::{entry, exception};

/// After reset the core runs from HSI, 16 MHz, and so do TIM2 and APB1: enough for 1 Mbit/s.
const CLOCK_HZ: u64 = 16_000_000;
/// RCC.
const AHB1ENR: usize = 0x30;
const APB1ENR: usize = 0x40;
/// GPIOA.
const MODER: usize = 0x00;
const PUPDR: usize = 0x0C;
const AFRL: usize = 0x20;
const AFRH: usize = 0x24;

/// Written by the interrupt, read by the main loop; room for a frame and a half.
static QUEUE: CaptureQueue<256> = CaptureQueue::new();

type Can = Bxcan<Block>;

#[derive(Clone, Copy)]
struct Tim2;

// SAFETY: TIM2 is number 28 [RM0090, table 61].
unsafe impl cortex_m::interrupt::InterruptNumber for Tim2 {
    fn number(self) -> u16 {
        28
    }
}

/// Every interrupt comes here, and that of TIM2 is the only one that is enabled. It has to be over
/// before the second next edge: 2 us at 1 Mbit/s.
#[exception]
unsafe fn DefaultHandler(_: i16) {
    // SAFETY: while the interrupt is enabled nothing but it touches status and capture registers.
    Capture::new(unsafe { Block::new(Block::TIM2) }).interrupt(&QUEUE);
}

#[entry]
fn main() -> ! {
    // SAFETY: each block is used here only; the timer's as its interrupt says.
    let (mut rcc, mut gpio, timer, can) = unsafe {
        let block = |base| Block::new(base);
        (block(Block::RCC), block(Block::GPIOA), block(Block::TIM2), block(Block::CAN1))
    };
    let Some(clock) = Hertz::new(CLOCK_HZ) else { stay_silent() };
    prepare(&mut rcc, &mut gpio);
    let mut timer = Capture::new(timer);
    let mut can = Bxcan::new(can, clock);
    loop {
        let mut measurement = Measurement::start(&mut timer, &QUEUE, clock);
        // SAFETY: the queue and the timer are ready for it.
        unsafe { NVIC::unmask(Tim2) };
        let bitrate = measure(&mut measurement);
        NVIC::mask(Tim2);
        // The counter goes on as the clock of what follows.
        let Some(bitrate) = bitrate else { continue };
        let heard;
        (can, heard) = verify(can, &timer, bitrate);
        if heard {
            take_part(bitrate);
        }
    }
}

/// Clocks and pins. PA12, TXD, is not connected to CAN1 here.
fn prepare(rcc: &mut Block, gpio: &mut Block) {
    const ALTERNATE: u32 = 0b10;
    const PULL_UP: u32 = 0b01;
    rcc.modify(AHB1ENR, 0, 1);
    rcc.modify(APB1ENR, 0, 1 | 1 << 25);
    gpio.modify(PUPDR, 0b11 << 24, PULL_UP << 24);
    // PA0: AF1, TIM2_CH1. PA11: AF9, CAN1_RX.
    gpio.modify(AFRL, 0xF, 1);
    gpio.modify(AFRH, 0xF << 12, 9 << 12);
    gpio.modify(MODER, 0b11 | 0b11 << 22, ALTERNATE | ALTERNATE << 22);
}

/// Sleeps until the next edge as long as more are wanted.
fn measure(measurement: &mut Measurement) -> Option<Bitrate> {
    loop {
        match measurement.turn(&QUEUE) {
            Measured::NotYet => wfi(),
            Measured::Rate(bitrate) => return Some(bitrate),
            Measured::OutOfRange => return None,
        }
    }
}

/// Whether frames are received at this rate, in silent mode; gives the controller back.
fn verify(can: Can, timer: &Capture<Block>, bitrate: Bitrate) -> (Can, bool) {
    let Ok(candidates) = Candidates::<1>::of_rates(&[bitrate]) else { return (can, false) };
    let scan = Scan::new(&candidates, &can.capabilities(), Settings::default());
    let (mut ticks, mut last) = (0, timer.now());
    let mut driver = Driver::new(can, scan, |_: &_| {
        let now = timer.now();
        ticks += u64::from(now.wrapping_sub(last));
        last = now;
        Micros(ticks / (CLOCK_HZ / 1_000_000))
    });
    loop {
        let heard = match driver.turn() {
            Ok(Progress::Done(outcome)) => matches!(outcome, Outcome::Found(_)),
            Ok(Progress::Listening(_)) => continue,
            Err(_) => false,
        };
        return (driver.into_controller(), heard);
    }
}

/// Here the application begins: it sets bxCAN to this rate without SILM, gives PA12 to CAN1, and has
/// another look when errors come, as `canbaud::node` does.
fn take_part(bitrate: Bitrate) -> ! {
    static RATE: AtomicU32 = AtomicU32::new(0);
    RATE.store(bitrate.bits_per_second(), Ordering::Relaxed);
    stay_silent()
}

fn stay_silent() -> ! {
    loop {
        wfi();
    }
}

/// Never linked: whoever reaches it makes the linker miss a symbol.
#[panic_handler]
fn panic(_: &PanicInfo<'_>) -> ! {
    unsafe extern "C" {
        fn a_panic_path_was_linked() -> !;
    }
    // SAFETY: the function does not exist, so code that could reach this call does not link.
    unsafe { a_panic_path_was_linked() }
}
