//! CAN FD: both rates, and what a controller that does not know it can say.

use crate::stage::*;

const FD: FrameKind = FrameKind::Fd { brs: true, esi: false };

fn fd_pair(bitrate: u32, data: u32) -> Scene {
    let fd = || node(bitrate).with_data_bitrate(data).expect("80 MHz makes this rate");
    Scene::new([fd(), fd()])
}

#[test]
fn a_classic_controller_says_that_a_mixed_bus_carries_fd() {
    let mut scene = fd_pair(500_000, 2_000_000);
    scene.talk_as(FD, at_ms(1), Span::from_ms(4), Payload::Random);
    scene.talk(at_ms(15), Span::from_ms(20), Payload::Random);
    let (outcome, _) = canopen(scene.controller(Adapter::embedded()), beginning_at(500_000));
    let found = found(outcome);
    assert_eq!((found.nominal(), found.fd), (rate(500_000), FdSeen::Suspected));
}

#[test]
fn a_classic_controller_on_a_bus_with_nothing_but_fd_says_which_rate_it_may_be() {
    let mut scene = fd_pair(500_000, 2_000_000);
    scene.talk_as(FD, at_ms(1), Span::from_ms(4), Payload::Random);
    let (outcome, _) = canopen(scene.controller(Adapter::embedded()), Settings::default());
    let Some(Outcome::NoCandidateFits(misfit)) = outcome else { panic!("{outcome:?}") };
    assert_eq!(misfit.perhaps_fd.map(|candidate| candidate.nominal), Some(rate(500_000)));
}

#[test]
fn an_fd_controller_finds_nominal_and_data_rate() {
    let data = [1_000_000, 2_000_000, 4_000_000, 5_000_000].map(rate);
    let nominal = [250_000, 500_000, 800_000].map(rate);
    let pairs = Candidates::<12>::of_rates(&nominal).unwrap().with_data(&data).unwrap();
    for classic in [true, false] {
        let mut scene = fd_pair(500_000, 4_000_000);
        scene.talk_as(FD, at_ms(1), Span::from_ms(7), Payload::Random);
        if classic {
            scene.talk(at_ms(2), Span::from_ms(6), Payload::Random);
        }
        let adapter = Adapter { fd: FdSupport::Fd, ..Adapter::embedded() };
        let (outcome, _) = scan(scene.controller(adapter), &pairs, Settings::default(), ms(30_000));
        let found = found(outcome);
        assert_eq!(found.nominal(), rate(500_000), "{classic}");
        assert_eq!(found.data(), Some(rate(4_000_000)), "{classic} {found:?}");
    }
}

#[test]
fn without_a_switched_frame_no_data_rate_is_said() {
    let pairs = Candidates::<2>::of_rates(&[rate(500_000)]).unwrap();
    let pairs = pairs.with_data(&[2_000_000, 4_000_000].map(rate)).unwrap();
    for (kind, seen) in [
        (FrameKind::Data, FdSeen::No),
        (FrameKind::Fd { brs: false, esi: false }, FdSeen::NeverSwitched),
    ] {
        let mut scene = fd_pair(500_000, 4_000_000);
        scene.talk_as(kind, at_ms(1), Span::from_ms(7), Payload::Random);
        let adapter = Adapter { fd: FdSupport::Fd, ..Adapter::embedded() };
        let (outcome, _) = scan(scene.controller(adapter), &pairs, Settings::default(), ms(30_000));
        assert_eq!((found(outcome).fd, found(outcome).data()), (seen, None));
    }
}
