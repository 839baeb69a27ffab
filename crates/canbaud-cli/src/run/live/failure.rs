//! What went wrong with an adapter: one line, and where there is one, a line with the way out.

use canbaud_link::{ErrorKind, LinkError};

use crate::exit::Exit;
use crate::printable::printable;
use crate::tell::tell;

/// Says it and gives the exit code.
pub(crate) fn link_error(error: &LinkError) -> Exit {
    tell!("canbaud: {}", printable(&error.to_string()));
    if let Some(hint) = hint(error) {
        tell!("  hint: {}", printable(&hint));
    }
    match error.kind() {
        ErrorKind::Permission => Exit::Permission,
        ErrorKind::Unusable => Exit::Unusable,
        ErrorKind::Unreadable => Exit::Unreadable,
    }
}

fn hint(error: &LinkError) -> Option<String> {
    Some(match error {
        LinkError::Permission { .. } => {
            format!("sudo setcap cap_net_admin+ep {}   (once; or run it with sudo)", this_program())
        }
        LinkError::PortPermission { .. } => {
            "sudo usermod -aG dialout $USER   (then log in again; some systems call it uucp)".into()
        }
        LinkError::NoKernelCan => {
            "sudo modprobe can_raw; a serial adapter needs no kernel CAN: canbaud detect \
             slcan:/dev/ttyACM0"
                .into()
        }
        LinkError::NoInterface { available, .. } if available.is_empty() => {
            "plug the adapter in, or load its driver; canbaud adapters shows what there is; a \
             serial adapter is slcan:/dev/ttyACM0"
                .into()
        }
        LinkError::NoAnswer { .. } => {
            "is that the port, and its bit rate? slcan:/dev/ttyUSB0@1000000".into()
        }
        LinkError::NoListenOnly { adapter, .. } if adapter.starts_with("/dev/") => {
            "candleLight firmware makes a CANable listen for sure (it is can0 then); --trust-m1 if \
             you know that this one honours M1"
                .into()
        }
        LinkError::PortBusy { .. } => {
            "end slcand, the modem manager or the terminal that uses it; of slcand, the bus is an \
             interface: canbaud adapters shows it"
                .into()
        }
        LinkError::Virtual { .. }
        | LinkError::NotCan { .. }
        | LinkError::NoPort { .. }
        | LinkError::NotSerial { .. } => "canbaud adapters shows what there is".into(),
        _ => return None,
    })
}

/// The real path of this program: a capability sticks to a file, not to a link to it.
fn this_program() -> String {
    let path = std::env::current_exe().and_then(|path| path.canonicalize());
    path.map_or_else(|_| "PATH/TO/canbaud".to_owned(), |path| path.display().to_string())
}
