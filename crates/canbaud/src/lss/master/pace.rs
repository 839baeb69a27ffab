//! How fast a master goes.

use crate::units::Micros;

/// Times of a master. CiA 305 neither names nor recommends any.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pace {
    /// How long an answer may take, slow devices and the way through an adapter included.
    pub answer_timeout: Micros,
    /// Pause between two frames of the master: some devices keep one frame only.
    pub inhibit: Micros,
    /// How long a service waits for a second, different answer once it has one.
    pub settle: Micros,
}

impl Default for Pace {
    /// 500 ms for an answer, 1 ms between frames, 10 ms for a second answer.
    fn default() -> Self {
        Self {
            answer_timeout: Micros::from_ms(500),
            inhibit: Micros::from_ms(1),
            settle: Micros::from_ms(10),
        }
    }
}
