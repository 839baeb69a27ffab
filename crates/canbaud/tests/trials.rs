//! The random recordings that the accuracy figures rest on are what they claim to be.

mod support;

use canbaud::wire::{Level, encode};
use support::bound::Bound;
use support::interval::feasible;
use support::judge::Truth;
use support::line::Phase;
use support::trial::{Resolution, Scene, Trial};

const SEED: u64 = 20;

fn trials(scene: Scene, resolution: Resolution) -> impl Iterator<Item = (u64, Trial)> {
    (0..400).map(move |number| (number, Trial::draw(SEED, number, scene, resolution)))
}

fn true_nominal(trial: &Trial) -> f64 {
    match trial.truth() {
        Truth::Bus { nominal, .. } => nominal,
        Truth::Foreign => f64::NAN,
    }
}

#[test]
fn stamps_of_every_scene_are_in_order_and_inside_the_recording() {
    for scene in Scene::ALL {
        for (number, trial) in trials(scene, Resolution::UsualTimers) {
            let recording = trial.record();
            let stamps: Vec<u64> = recording.edges.iter().map(|edge| edge.at).collect();
            assert!(stamps.is_sorted(), "seed {SEED} trial {number}: {trial:?}");
            let inside = stamps.iter().all(|at| (recording.begin..=recording.finish).contains(at));
            assert!(inside, "seed {SEED} trial {number}: {trial:?}");
            let again = Trial::draw(SEED, number, scene, Resolution::UsualTimers).record();
            assert!(again.edges.iter().map(|edge| edge.at).eq(stamps), "trial {number} varies");
        }
    }
}

/// Reads the bits off the time axis with the true bit time: they are the encoder's.
#[test]
fn clean_recording_read_at_true_rate_gives_encoded_bits() {
    for (number, trial) in trials(Scene::Clean, Resolution::TicksPerBit(20.0)) {
        let recording = trial.record();
        let encoded = encode(&trial.frame, trial.fd_crc);
        let first = recording.edges[0].at as f64 - 0.5;
        let mut sampled = Vec::new();
        for bit in 0..=encoded.crc_delimiter {
            let middle = first + (bit as f64 + 0.5) * true_nominal(&trial);
            let toggles = recording.edges.iter().filter(|edge| (edge.at as f64) < middle).count();
            sampled.push(if toggles % 2 == 1 { Level::Dominant } else { Level::Recessive });
        }
        let expected: Vec<Level> = encoded.bits.iter().take(sampled.len()).collect();
        assert_eq!(sampled, expected, "seed {SEED} trial {number}: {trial:?}");
    }
}

/// The true bit time is always among those that the stamps allow: grid and stamps agree.
#[test]
fn stamps_without_distortion_allow_the_true_bit_time() {
    for scene in [Scene::Clean, Scene::Cut, Scene::ErrorFlag, Scene::Unacknowledged, Scene::Fd] {
        for (number, trial) in trials(scene, Resolution::UsualTimers) {
            let truth = true_nominal(&trial);
            let range = feasible(&trial.record().edges, Phase::Nominal);
            let (least, greatest) = range.expect("every frame has edges");
            // The ends of the range belong to it; the arithmetic rounds.
            let slack = truth * 1e-9;
            assert!(
                least - slack <= truth && truth <= greatest + slack,
                "seed {SEED} trial {number}: {truth} outside {least} to {greatest}: {trial:?}"
            );
        }
    }
}

/// With many ticks per bit the quantisation is white, and least squares reaches its own bound.
#[test]
fn least_squares_with_true_bit_numbers_reaches_the_bound() {
    for scene in [Scene::Clean, Scene::Asymmetry, Scene::Jitter] {
        let mut squares = 0.0;
        let mut count = 0.0;
        for (_, trial) in trials(scene, Resolution::TicksPerBit(333.3)) {
            let best = Bound::of(&trial.record().edges, trial.edge_noise()).nominal;
            let best = best.expect("a frame has edges enough");
            squares += ((best.ticks - true_nominal(&trial)) / best.sigma).powi(2);
            count += 1.0;
        }
        let ratio = f64::sqrt(squares / count);
        assert!((0.9..1.1).contains(&ratio), "{scene:?}: {ratio}");
    }
}
