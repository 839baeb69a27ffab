use super::*;

const LIMITS: fn() -> TimingConst = || TimingConst {
    name: "sja1000".to_owned(),
    tseg1: (1, 16),
    tseg2: (1, 8),
    sjw_max: 4,
    brp: (1, 64),
    brp_inc: 1,
};

const TIMING: TimingInfo = TimingInfo {
    bitrate: 250_000,
    sample_point: 875,
    tq: 250,
    prop_seg: 6,
    phase_seg1: 7,
    phase_seg2: 2,
    sjw: 1,
    brp: 2,
};

#[test]
fn a_wide_setting_keeps_the_rate_and_moves_the_sample_point() {
    let wide = wide(TIMING, &LIMITS()).unwrap();
    assert_eq!((wide.tq, wide.quanta()), (250, 16));
    assert_eq!((wide.prop_seg, wide.phase_seg1, wide.phase_seg2, wide.sjw), (1, 7, 7, 4));
    // Either rate or TQ: the kernel refuses both together.
    assert_eq!((wide.bitrate, wide.brp), (0, 0));
}

#[test]
fn limits_are_kept() {
    let limits = TimingConst { tseg2: (1, 3), sjw_max: 2, ..LIMITS() };
    let narrow = wide(TIMING, &limits).unwrap();
    assert_eq!((narrow.phase_seg2, narrow.sjw, narrow.quanta()), (3, 2, 16));
    // TSEG1 is too short for the rest: TSEG2 takes more than half.
    let limits = TimingConst { tseg1: (1, 7), tseg2: (1, 8), ..LIMITS() };
    assert_eq!(wide(TIMING, &limits).unwrap().phase_seg2, 8);
    let limits = TimingConst { tseg1: (1, 4), tseg2: (1, 4), ..LIMITS() };
    assert_eq!(wide(TIMING, &limits), None);
    // A bit of a few TQ, as hostile as numbers get.
    for tq in [0, 1, u32::MAX] {
        let odd = TimingInfo { prop_seg: tq, phase_seg1: tq, phase_seg2: tq, ..TIMING };
        let _ = wide(odd, &LIMITS());
    }
}
