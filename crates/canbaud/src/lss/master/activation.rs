//! Activate bit timing, and go along with it.

use crate::lss::Request;
use crate::units::Micros;
use crate::wire::Frame;

/// What an activation wants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(clippy::large_enum_variant, reason = "no_std: actions live on the stack")]
pub enum ActivationAction {
    /// Send this frame, and nothing behind it until [`ActivationAction::Done`].
    Send(Frame),
    /// The slaves have switched: set the own interface to the new bit rate now. Nobody sends until
    /// the time given, by which it has to be done.
    SwitchBitRate {
        /// The end of the second period.
        until: Micros,
    },
    /// Both periods are over: everybody may send.
    Done,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Turn {
    Send,
    First { began: Micros },
    Second { began: Micros },
    Over,
}

/// Activate bit timing: the command, the first period, the switch, the second period [CiA 305].
///
/// A slave counts from when it has received the command, which is later than the master sent it;
/// so each step of the master has a tenth of the delay, at least 5 ms, to spare.
///
/// ```
/// use canbaud::lss::{Activation, ActivationAction, Request};
/// use canbaud::units::Micros;
///
/// let mut activation = Activation::new(100);
/// let command = Request::ActivateBitTiming { switch_delay_ms: 100 }.to_frame();
/// assert_eq!(activation.poll(Micros(0)), Some(ActivationAction::Send(command)));
/// assert_eq!(activation.poll(Micros::from_ms(100)), None);
/// let switch = ActivationAction::SwitchBitRate { until: Micros::from_ms(200) };
/// assert_eq!(activation.poll(Micros::from_ms(110)), Some(switch));
/// assert_eq!(activation.poll(Micros::from_ms(210)), Some(ActivationAction::Done));
/// ```
#[derive(Debug, Clone)]
pub struct Activation {
    delay: Micros,
    turn: Turn,
}

impl Activation {
    /// An activation with two periods of `switch_delay_ms`, each longer than the slowest slave
    /// takes to process a command and the own interface to be set up.
    #[must_use]
    pub const fn new(switch_delay_ms: u16) -> Self {
        Self { delay: Micros::from_ms(switch_delay_ms as u64), turn: Turn::Send }
    }

    /// The next thing to do at `now`.
    pub fn poll(&mut self, now: Micros) -> Option<ActivationAction> {
        let due = now >= self.deadline();
        match self.turn {
            Turn::Send => {
                self.turn = Turn::First { began: now };
                let switch_delay_ms = u16::try_from(self.delay.ms()).unwrap_or(u16::MAX);
                Some(ActivationAction::Send(
                    Request::ActivateBitTiming { switch_delay_ms }.to_frame(),
                ))
            }
            Turn::First { began } if due => {
                self.turn = Turn::Second { began };
                let until = began + self.delay.times(2);
                Some(ActivationAction::SwitchBitRate { until })
            }
            Turn::Second { .. } if due => {
                self.turn = Turn::Over;
                Some(ActivationAction::Done)
            }
            Turn::First { .. } | Turn::Second { .. } | Turn::Over => None,
        }
    }

    /// When to call [`Activation::poll`] next; [`Micros::MAX`] once it is over.
    #[must_use]
    pub fn deadline(&self) -> Micros {
        let spare = Micros(self.delay.0 / 10).max(Micros::from_ms(5));
        match self.turn {
            Turn::Send => Micros(0),
            Turn::First { began } => began + self.delay + spare,
            Turn::Second { began } => began + self.delay.times(2) + spare,
            Turn::Over => Micros::MAX,
        }
    }
}
