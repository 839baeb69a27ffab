//! A CANopen node that finds its way into any network, and back into it.
//!
//! [`Node`] is one state machine from power-on to operation: it listens in silence until the bit
//! rate is known, takes part, sends its boot-up message, and after bus-off begins again. It does no
//! I/O: what happens comes in by [`Node::handle`] and [`Node::edge`], what is to be done comes out
//! of [`Node::poll`].
//!
//! | part | what it is |
//! |---|---|
//! | [`Settings`] | what the device has, and how it is set |
//! | [`Input`], [`Action`] | what happens, and what is to be done |
//! | [`load`], [`save`], [`Storage`] | what it remembers over a loss of power |
//! | [`Leds`], [`Pattern`] | what the RUN and ERROR LEDs show |
//! | [`NmtState`], [`NmtCommand`] | network management, as far as coming up needs it |
//!
//! Sources: \[AP2925 figure 3\], \[Koppe\], \[CiA 301\], \[CiA 303-3\], \[CiA 305\].

mod active;
mod led;
mod machine;
mod measure;
mod nmt;
mod patience;
mod record;
mod recovering;
mod search;
mod settings;
mod signal;

pub use led::{Leds, Pattern};
pub use machine::{Node, Stage};
pub use nmt::{NmtCommand, NmtState, boot_up, heartbeat};
pub use record::{RECORD_OVERHEAD, SaveError, Slot, Storage, load, save};
pub use settings::{Means, Settings, SettingsError, Silence, Startup};
pub use signal::{Action, Input, Sending};
