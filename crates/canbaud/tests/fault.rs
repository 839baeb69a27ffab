//! Error confinement rule by rule; rows D1 and D2 of `docs/mission.md`.

use canbaud::fault::{
    ErrorConfinement, FlagCause, Occurrence, ReceiveReturn, Recovery, Role, State,
};
use canbaud::wire::Level::{Dominant, Recessive};

const SENDER_ERROR: Occurrence = Occurrence::TransmitterError(FlagCause::Other);

/// A node with the counters given, reached by the rules alone; REC up to 127, TEC a multiple of 8.
fn node(tec: u16, rec: u16) -> ErrorConfinement {
    assert!(tec.is_multiple_of(8) && rec < 128);
    let mut node = ErrorConfinement::new();
    for _ in 0..tec / 8 {
        node.count(SENDER_ERROR);
    }
    for _ in 0..rec {
        node.count(Occurrence::ReceiverError);
    }
    assert_eq!((node.tec(), node.rec()), (tec, rec));
    node
}

/// Each occurrence at ordinary counters, as the table of the standard says.
#[test]
fn each_rule_counts_what_the_standard_says() {
    #[rustfmt::skip]
    let table = [
        (1, Occurrence::ReceiverError, 80, 41),
        (2, Occurrence::DominantAfterFlag, 80, 48),
        (3, SENDER_ERROR, 88, 40),
        (3, Occurrence::TransmitterError(FlagCause::NobodyThere), 88, 40),
        (3, Occurrence::TransmitterError(FlagCause::OverwrittenStuffBit), 80, 40),
        (4, Occurrence::FlagBitError(Role::Transmitter), 88, 40),
        (5, Occurrence::FlagBitError(Role::Receiver), 80, 48),
        (6, Occurrence::DominantRun(Role::Transmitter), 88, 40),
        (6, Occurrence::DominantRun(Role::Receiver), 80, 48),
        (7, Occurrence::Transmitted, 79, 40),
        (8, Occurrence::Received, 80, 39),
    ];
    for (rule, occurrence, tec, rec) in table {
        let mut node = node(80, 40);
        assert_eq!(node.count(occurrence), None, "rule {rule}");
        assert_eq!((node.tec(), node.rec()), (tec, rec), "rule {rule}: {occurrence:?}");
    }
}

#[test]
fn counters_do_not_fall_below_zero() {
    let mut node = ErrorConfinement::new();
    node.count(Occurrence::Transmitted);
    node.count(Occurrence::Received);
    assert_eq!((node.tec(), node.rec()), (0, 0));
}

/// D1: error passive at 128 of either counter, active again only when both are below.
#[test]
fn d1_error_passive_at_128_and_back_below() {
    let mut sender = node(120, 0);
    assert_eq!(sender.state(), State::ErrorActive);
    assert_eq!(sender.count(SENDER_ERROR), Some(State::ErrorPassive));
    assert_eq!(sender.tec(), 128);
    assert_eq!(sender.count(Occurrence::Transmitted), Some(State::ErrorActive));

    let mut receiver = node(0, 127);
    assert_eq!(receiver.state(), State::ErrorActive);
    assert_eq!(receiver.count(Occurrence::ReceiverError), Some(State::ErrorPassive));

    // Both past the limit: one of them below it is not enough.
    let mut both = node(128, 127);
    both.count(Occurrence::ReceiverError);
    assert_eq!(both.count(Occurrence::Transmitted), None);
    assert_eq!((both.tec(), both.rec(), both.state()), (127, 128, State::ErrorPassive));
    assert_eq!(both.count(Occurrence::Received), Some(State::ErrorActive));
}

/// D1: bus-off at TEC >= 256, not at 255.
#[test]
fn d1_bus_off_at_256() {
    let mut sender = node(248, 0);
    for _ in 0..3 {
        sender.count(Occurrence::Transmitted);
    }
    sender.count(SENDER_ERROR);
    assert_eq!((sender.tec(), sender.state()), (253, State::ErrorPassive));
    assert_eq!(sender.count(SENDER_ERROR), Some(State::BusOff));
    assert_eq!(sender.tec(), 261);

    let mut sender = node(248, 0);
    assert_eq!(sender.count(SENDER_ERROR), Some(State::BusOff));
    assert_eq!(sender.tec(), 256);
}

/// D1: REC is not increased past the passive limit, and a good reception sets it to 119..127.
#[test]
fn d1_rec_stays_past_the_limit_and_returns_to_119_to_127() {
    for value in 119..=127 {
        let back = ReceiveReturn::new(value).unwrap();
        let mut receiver = ErrorConfinement::with_receive_return(back);
        for _ in 0..120 {
            receiver.count(Occurrence::ReceiverError);
        }
        // From 120 by 8: the last step that counts.
        assert_eq!(receiver.count(Occurrence::DominantAfterFlag), Some(State::ErrorPassive));
        assert_eq!(receiver.rec(), 128);
        for error in [
            Occurrence::ReceiverError,
            Occurrence::DominantAfterFlag,
            Occurrence::FlagBitError(Role::Receiver),
            Occurrence::DominantRun(Role::Receiver),
        ] {
            assert_eq!(receiver.count(error), None);
            assert_eq!(receiver.rec(), 128);
        }
        assert_eq!(receiver.count(Occurrence::Received), Some(State::ErrorActive));
        assert_eq!(receiver.rec(), u16::from(value));
        receiver.count(Occurrence::Received);
        assert_eq!(receiver.rec(), u16::from(value) - 1);
    }
    assert_eq!(ReceiveReturn::new(118), None);
    assert_eq!(ReceiveReturn::new(128), None);
    assert_eq!(ReceiveReturn::default().value(), 119);
}

/// Rule 3, exception A: a lone sender stays error passive for ever, and never goes bus-off.
#[test]
fn lone_sender_stops_at_128() {
    let mut sender = ErrorConfinement::new();
    for attempt in 1..=1000_u32 {
        let change = sender.count(Occurrence::TransmitterError(FlagCause::NobodyThere));
        assert_eq!(change, (attempt == 16).then_some(State::ErrorPassive));
    }
    assert_eq!(sender.tec(), 128);
}

/// D2: 128 occurrences of 11 recessive bits, neither 127 nor 128 of 10, then both counters 0.
#[test]
fn d2_recovery_takes_128_occurrences_of_11_recessive_bits() {
    let mut sender = node(248, 100);
    assert_eq!(sender.count(SENDER_ERROR), Some(State::BusOff));
    // REC is cleared and counts the occurrences from here on.
    assert_eq!(sender.rec(), 0);
    // Nothing of the bus counts any more.
    assert_eq!(sender.count(Occurrence::ReceiverError), None);
    assert_eq!(sender.count(Occurrence::Transmitted), None);
    // Ten at a time are none.
    for _ in 0..1000 {
        assert_eq!(sender.recessive_bits(10), None);
        assert_eq!(sender.bit(Dominant), None);
    }
    assert_eq!(sender.recovery().map(|r| r.occurrences()), Some(0));
    for occurrence in 1..=128_u8 {
        for bit in 1..=11 {
            let change = sender.bit(Recessive);
            let last = occurrence == 128 && bit == 11;
            assert_eq!(change, last.then_some(State::ErrorActive));
        }
        let expected = (occurrence < 128).then_some(occurrence);
        assert_eq!(sender.recovery().map(|r| r.occurrences()), expected);
        // A frame of somebody else between them does no harm.
        assert_eq!(sender.bit(Dominant), None);
    }
    assert_eq!((sender.tec(), sender.rec(), sender.state()), (0, 0, State::ErrorActive));
    assert_eq!(sender.count(SENDER_ERROR), None);
    assert_eq!(sender.tec(), 8);
}

#[test]
fn an_idle_bus_ends_bus_off_after_1408_bits() {
    let mut recovery = Recovery::new();
    recovery.recessive(1407);
    assert!(!recovery.is_complete());
    recovery.recessive(1);
    assert!(recovery.is_complete());
    recovery.recessive(u32::MAX);
    assert_eq!(recovery.occurrences(), 128);
}

/// Whatever comes: no panic, TEC at most 263, REC at most 135, and the state is that of the
/// counters until bus-off.
#[test]
fn counters_are_bounded_whatever_happens() {
    let all = [
        Occurrence::ReceiverError,
        Occurrence::DominantAfterFlag,
        SENDER_ERROR,
        Occurrence::TransmitterError(FlagCause::NobodyThere),
        Occurrence::TransmitterError(FlagCause::OverwrittenStuffBit),
        Occurrence::FlagBitError(Role::Transmitter),
        Occurrence::FlagBitError(Role::Receiver),
        Occurrence::DominantRun(Role::Transmitter),
        Occurrence::DominantRun(Role::Receiver),
        Occurrence::Transmitted,
        Occurrence::Received,
    ];
    let mut node = ErrorConfinement::new();
    let mut random: u32 = 1;
    let (mut bus_offs, mut highest) = (0, (0, 0));
    for _ in 0..200_000 {
        random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        let before = node.state();
        let change = match random >> 28 {
            at @ 0..=10 => node.count(all[at as usize]),
            11 => node.bit(Dominant),
            _ => node.recessive_bits(40),
        };
        assert_eq!(change, (before != node.state()).then_some(node.state()));
        bus_offs += u32::from(change == Some(State::BusOff));
        highest = (node.tec().max(highest.0), node.rec().max(highest.1));
    }
    assert!(bus_offs > 50, "{bus_offs}");
    assert!((256..=263).contains(&highest.0) && (128..=135).contains(&highest.1), "{highest:?}");
}
