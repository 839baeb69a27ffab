//! What a burst of errors at one rate says about the others.

use super::burst::Burst;
use super::track::BIT;
use crate::units::{Bitrate, Micros, Permille};

/// Binary logarithm in sixteenths; 0 for 0.
#[inline(never)]
pub(super) const fn log2(value: u64) -> i32 {
    if value == 0 {
        return 0;
    }
    let whole = value.ilog2();
    // The four bits behind the leading one; a straight line between powers of two is near enough.
    let fraction = if whole >= 4 { value >> (whole - 4) } else { value << (4 - whole) } & 15;
    BIT * whole as i32 + fraction as i32
}

/// What one burst of errors speaks against a rate at which this share of frames is destroyed.
pub(super) const fn error_bits(destroyed: Permille) -> i32 {
    let share = destroyed.permille();
    if share == 0 {
        return 10 * BIT;
    }
    let bits = log2(1000) - log2(share as u64);
    if bits < BIT { BIT } else { bits }
}

/// How likely `burst` is for a receiver at `listened_at` on a bus of `rate`, as a logarithm.
///
/// The figures come from simulated frames of 0 to 8 bytes at every pair of CANopen rates
/// (`docs/scan.md`): a receiver that is too fast tells some errors for each frame, one about every
/// five bits of the bus, from near the beginning to near the end; one that is too slow tells one.
///
/// Where errors are told in a batch, their times are true within `slack`.
pub(super) fn explain(burst: &Burst, listened_at: Bitrate, rate: Bitrate, slack: Micros) -> i32 {
    let (receiver, bus) = (listened_at.bits_per_second(), rate.bits_per_second());
    // The same rate with another data rate, or one that the receiver cannot tell from it.
    if receiver.abs_diff(bus) <= bus / 50 {
        return 0;
    }
    if receiver < bus {
        return too_slow(burst, listened_at);
    }
    let many = receiver / 3 >= bus;
    match burst.count {
        1 => -BIT * if many { 8 } else { 4 },
        2 | 3 => -BIT * if many { 5 } else { 2 },
        _ if burst.is_faithful(listened_at) => {
            let exactly = (burst.span(), burst.span());
            -density_penalty(burst, receiver, bus, exactly)
                - span_penalty(burst, bus, exactly)
                - closest_penalty(burst, receiver, bus)
        }
        _ => {
            let about = (burst.span() - slack, burst.span() + slack);
            -density_penalty(burst, receiver, bus, about) - span_penalty(burst, bus, about)
        }
    }
}

fn too_slow(burst: &Burst, listened_at: Bitrate) -> i32 {
    match burst.count {
        1 => 0,
        // One in each frame of a loaded bus.
        _ if burst.is_sparse(listened_at) => -BIT,
        // On a loaded bus it does not find back, and takes one delimiter after the other amiss.
        _ if !burst.is_single() => -BIT / 2,
        2 | 3 => -2 * BIT,
        _ => -4 * BIT,
    }
}

/// A span in bits of the bus, as a logarithm.
#[inline(never)]
fn bits_of(span: Micros, bus: u32) -> i32 {
    log2(span.0.saturating_mul(u64::from(bus)).saturating_mul(16) / 1_000_000) - 4 * BIT
}

/// No likelihood is trusted further than this.
const WORST: i32 = 8 * BIT;

/// How far the errors are apart, on average, if their span lies between these.
fn density_penalty(burst: &Burst, receiver: u32, bus: u32, (least, most): (Micros, Micros)) -> i32 {
    // Errors for each bit, as a logarithm, and the factor that the variance makes, in 32nds.
    let (expected, sharpness) = match receiver / bus {
        0..3 => (-44, 7),
        3..11 => (-38, 7),
        _ => (-30, 23),
    };
    if burst.counted {
        return 0;
    }
    let bits = log2(u64::from(burst.count - 1)) - expected;
    let off = bits - bits.min(bits_of(most, bus)).max(bits_of(least, bus));
    let off = off.clamp(-64, 64);
    (off * off * sharpness / 32).min(WORST)
}

/// How long the burst is, between these: most of a frame.
fn span_penalty(burst: &Burst, bus: u32, (least, most): (Micros, Micros)) -> i32 {
    // 70 bits; beyond 125 there was more than one frame.
    const USUAL: i32 = 98;
    const LONG: i32 = 111;
    if bits_of(least, bus) > LONG {
        return if burst.is_single() { 5 * BIT } else { 3 * BIT / 2 };
    }
    if burst.saturated {
        return 0;
    }
    let short = (USUAL - bits_of(most, bus)).clamp(0, 64);
    (short * short * 5 / 32).min(WORST)
}

/// How near two errors come: two bits of the bus, or what the receiver needs for its own flag.
fn closest_penalty(burst: &Burst, receiver: u32, bus: u32) -> i32 {
    // Time stamps are whole microseconds: one more or less.
    let eighths = |bits: u64, rate: u32| bits * 125_000 / u64::from(rate);
    let least = eighths(10, bus).max(eighths(60, receiver)).saturating_sub(1);
    let most = eighths(26, bus).max(eighths(84, receiver)) + 1;
    let closest = burst.closest.0;
    if closest < least || (burst.count >= 8 && closest > most) { 6 * BIT } else { 0 }
}
