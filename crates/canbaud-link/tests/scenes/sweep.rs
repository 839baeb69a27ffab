//! Rates that are in no list.

use crate::stage::*;

#[test]
fn a_sweep_finds_nobodys_rate_and_listening_again_says_it_more_exactly() {
    for bitrate in [13_000, 47_619, 470_000, 930_000] {
        let bus = || {
            let mut scene = Scene::pair(bitrate);
            scene.talk(at_ms(1), Span::from_ms(11), Payload::Random);
            scene.controller(Adapter::embedded())
        };
        let inside = |found: &Found| {
            let (low, high) = found.interval();
            (low..=high).contains(&rate(bitrate))
        };
        let sweep = Candidates::<100>::sweep(rate(10_000), rate(1_000_000)).unwrap();
        let (outcome, _) = scan(bus(), &sweep, Settings::default(), ms(300_000));
        let wide = found(outcome);
        assert!(inside(&wide), "{bitrate}: {wide:?}");
        let again = Candidates::<17>::around(&wide).unwrap();
        let survey = Settings { policy: Policy::Survey, ..Settings::default() };
        let (outcome, _) = scan(bus(), &again, survey, ms(60_000));
        let narrow = found(outcome);
        let width = |found: &Found| {
            found.interval().1.bits_per_second() - found.interval().0.bits_per_second()
        };
        assert!(width(&narrow) * 3 < width(&wide), "{bitrate}: {narrow:?}");
        assert!(inside(&narrow), "{bitrate}: {narrow:?}");
    }
}

#[test]
fn rates_that_a_receiver_cannot_tell_apart_are_one_class() {
    for bitrate in [615_385, 625_000] {
        let mut scene = Scene::pair(bitrate);
        scene.talk(at_ms(1), Span::from_ms(11), Payload::Random);
        let known = Candidates::<26>::known().unwrap();
        let controller = scene.controller(Adapter::embedded());
        let (outcome, _) = scan(controller, &known, Settings::default(), ms(60_000));
        let class: Vec<_> = found(outcome).class().map(|known| known.bitrate()).collect();
        assert_eq!(class, [rate(615_385), rate(625_000)], "{bitrate}");
    }
}
