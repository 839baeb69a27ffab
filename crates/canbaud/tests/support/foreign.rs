//! Lines that are no CAN bus: a detector must not find a rate there.

use super::prng::Prng;
use super::sender::Player;

/// What the line carries instead.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Foreign {
    /// Asynchronous serial characters, 8 data bits, no parity, 1 stop bit.
    Uart,
    /// Manchester code.
    Manchester,
    /// A clock.
    Clock,
    /// Pulses of a servo or a dimmer: fixed period, varying width.
    PulseWidth,
    /// Pulses of random width.
    Noise,
    /// Random bits on a grid, without stuffing.
    RandomBits,
}

/// All of them.
pub const ALL: [Foreign; 6] = [
    Foreign::Uart,
    Foreign::Manchester,
    Foreign::Clock,
    Foreign::PulseWidth,
    Foreign::Noise,
    Foreign::RandomBits,
];

/// Some 600 bit times of `what`, with gaps.
pub fn play(player: &mut Player, what: Foreign, bit: f64, prng: &mut Prng) {
    for _ in 0..prng.below(6) + 1 {
        match what {
            Foreign::Uart => uart(player, bit, prng),
            Foreign::Manchester => manchester(player, bit, prng),
            Foreign::Clock => pulses(player, 40, || (bit, bit)),
            Foreign::PulseWidth => {
                pulses(player, 20, || {
                    let low = prng.uniform(1.0, 9.0) * bit;
                    (low, 10.0 * bit - low)
                });
            }
            Foreign::Noise => {
                pulses(player, 40, || (prng.uniform(0.3, 5.5) * bit, prng.uniform(0.3, 5.5) * bit));
            }
            Foreign::RandomBits => {
                let bits: Vec<bool> = (0..100).map(|_| prng.chance(0.5)).collect();
                levels(player, bit, &bits);
            }
        }
        player.idle(prng.uniform(0.0, 40.0) * bit);
    }
}

/// Ten characters back to back.
fn uart(player: &mut Player, bit: f64, prng: &mut Prng) {
    let mut bits = Vec::new();
    for _ in 0..10 {
        let byte = prng.below(256);
        bits.push(true);
        bits.extend((0..8).map(|i| (byte >> i) & 1 == 0));
        bits.push(false);
    }
    levels(player, bit, &bits);
}

/// Sixty bits, each with an edge in the middle.
fn manchester(player: &mut Player, bit: f64, prng: &mut Prng) {
    let halves: Vec<bool> = (0..60)
        .flat_map(|_| if prng.chance(0.5) { [true, false] } else { [false, true] })
        .collect();
    levels(player, bit, &halves);
}

/// `true` is dominant.
fn levels(player: &mut Player, bit: f64, bits: &[bool]) {
    for &dominant in bits {
        if dominant {
            player.drive(player.now, player.now + bit);
        }
        player.idle(bit);
    }
}

/// Pulses of the given dominant and recessive widths.
fn pulses(player: &mut Player, count: u32, mut widths: impl FnMut() -> (f64, f64)) {
    for _ in 0..count {
        let (low, high) = widths();
        player.drive(player.now, player.now + low);
        player.idle(low + high);
    }
}
