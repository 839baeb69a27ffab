//! `canbaud lss`: bit rate and node-ID of CANopen devices, over the bus.

mod args;
mod channel;
mod configure;
mod network;
mod parse;
mod scan;
mod serve;
mod session;
mod trouble;
mod watched;

pub(crate) use args::{LSS_HELP, LssArgs};
pub(crate) use channel::Channel;
pub(crate) use trouble::Trouble;
pub(crate) use watched::Watched;

use std::io;

use args::LssAction;
use session::Session;

use crate::exit::Exit;
use crate::run::live::link_error;
use crate::tell::tell;

/// Exit codes: 0 done, 2 wrong command line, 3 refused or contradictory answers, 4 no answer, 6 no
/// permission, 7 the channel cannot be used, or is not as it was found; that goes first.
pub(crate) fn lss(args: &LssArgs) -> Exit {
    let mut session = match Session::open(args.action.line()) {
        Ok(session) => session,
        Err(trouble) => return report(&trouble),
    };
    let done = run(&args.action, &mut session);
    // What was changed goes back first: who reads may be slow, or gone.
    let ended = session.end();
    let exit = done.err().map_or(Exit::Found, |trouble| report(&trouble));
    match ended {
        Ok(()) => exit,
        Err(trouble @ Trouble::NotRestored(..)) => report(&trouble),
        Err(trouble) => exit.max(report(&trouble)),
    }
}

/// Says what went wrong, and gives its exit code.
pub(crate) fn report(trouble: &Trouble) -> Exit {
    match trouble {
        Trouble::Link(error) => return link_error(error),
        // A reader that has seen enough is told nothing.
        Trouble::Output(error) if error.kind() == io::ErrorKind::BrokenPipe => {}
        trouble => {
            tell!("canbaud: {trouble}");
            if let Some(hint) = trouble.hint() {
                tell!("  hint: {hint}");
            }
        }
    }
    trouble.exit()
}

fn run(action: &LssAction, session: &mut Session) -> Result<(), Trouble> {
    match action {
        LssAction::Scan(args) => scan::scan(args, session),
        LssAction::Inquire(args) => configure::inquire(args, session),
        LssAction::SetNodeId(args) => configure::set_node_id(args, session),
        LssAction::SetBitrate(args) => configure::set_bitrate(args, session),
        LssAction::Store(args) => configure::store(args, session),
        LssAction::Auto(args) => configure::auto(args, session),
        LssAction::Activate(args) => network::activate(args, session),
        LssAction::Serve(args) => serve::serve(args, session),
    }
}
