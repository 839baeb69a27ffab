//! `canbaud lss activate`: the whole network at once.

use canbaud::lss::{LssState, Service};

use super::args::ActivateArgs;
use super::configure::warn;
use super::session::Session;
use super::trouble::Trouble;

/// All devices switch to what was set in them, the own channel with them.
pub(super) fn activate(args: &ActivateArgs, session: &mut Session) -> Result<(), Trouble> {
    session.exchange(Service::SwitchStateGlobal(LssState::Configuration))?;
    let activated = session.activate(args.delay, args.to)?;
    warn(session, activated);
    session.release()?;
    let channel = session.channel().clone();
    match args.to {
        Some(rate) => {
            session.say(&format!("activated; {channel} is at {rate} now"));
            session.keep(rate);
        }
        None => session.say(&format!("activated; {channel} stays at its bit rate")),
    }
    Ok(())
}
