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

pub(crate) use args::{LSS_HELP, LssArgs};
pub(crate) use channel::Channel;
pub(crate) use trouble::Trouble;

use args::LssAction;
use session::Session;

use crate::exit::Exit;
use crate::run::live::link_error;

/// Exit codes: 0 done, 2 wrong command line, 3 refused or contradictory answers, 4 no answer, 6 no
/// permission, 7 the channel cannot be used.
pub(crate) fn lss(args: &LssArgs) -> Exit {
    match run(&args.action) {
        Ok(()) => Exit::Found,
        Err(Trouble::Link(error)) => link_error(&error),
        Err(trouble) => {
            eprintln!("canbaud: {trouble}");
            if let Some(hint) = trouble.hint() {
                eprintln!("  hint: {hint}");
            }
            trouble.exit()
        }
    }
}

fn run(action: &LssAction) -> Result<(), Trouble> {
    let line = action.line();
    let mut session = Session::open(line)?;
    match action {
        LssAction::Scan(args) => scan::scan(args, &mut session),
        LssAction::Inquire(args) => configure::inquire(args, &mut session),
        LssAction::SetNodeId(args) => configure::set_node_id(args, &mut session),
        LssAction::SetBitrate(args) => configure::set_bitrate(args, &mut session),
        LssAction::Store(args) => configure::store(args, &mut session),
        LssAction::Auto(args) => configure::auto(args, &mut session),
        LssAction::Activate(args) => network::activate(args, &mut session),
        LssAction::Serve(args) => serve::serve(args, &mut session),
    }
}
