//! The autonomous node against a controller in memory: it listens until it knows the rate, takes
//! part, boots up, and after bus-off finds its way back.
#![no_std]
#![no_main]

use canbaud::detect::scan::Controller;
use canbaud::fault::State;
use canbaud::lss::NodeId;
use canbaud::node::{Action, Input, Means, Node, Settings, Stage};
use canbaud::units::{Bitrate, Micros};
use canbaud_firmware::bus::{CAPABILITIES, MemoryController};
use canbaud_firmware::console::{self, Status, print, print_number, print_pair};
use cortex_m_rt::entry;

#[entry]
fn main() -> ! {
    print_pair("node_ram_bytes", size_of::<Node>() as u64);
    let ok = Bitrate::new(250_000).and_then(live).is_some();
    console::exit(if ok { Status::Ok } else { Status::Failed })
}

/// A life of the node on a bus with this rate; `None` if it does not come up, or come back.
fn live(bus: Bitrate) -> Option<()> {
    let settings = Settings::automatic(NodeId::new(5)?, Means::Controller(CAPABILITIES));
    let mut node: Node = Node::new(settings, None, Micros(0)).ok()?;
    let mut controller = MemoryController::new(bus);
    let (mut sent, mut ups) = (0_u32, 0_u32);
    let mut up = false;
    for tick in 1..4_000_000_u64 {
        let now = Micros(tick * 250);
        while let Some(action) = node.poll(now) {
            sent += u32::from(matches!(action, Action::Send(_)));
            if let Some(answer) = carry_out(&action, &mut controller, bus) {
                node.handle(now, &answer);
            }
        }
        if let Ok(Some(heard)) = controller.observe(now) {
            node.handle(now, &Input::Heard(heard));
        }
        let is_up = matches!(node.stage(), Stage::TakingPart { nmt: Some(_), .. });
        if is_up && !up {
            ups += 1;
            print("up after ");
            print_number(now.ms());
            print(" ms\n");
            if ups == 2 {
                return (sent >= 2).then_some(());
            }
            // Somebody pulls the plug out and puts it into another network.
            node.handle(now, &Input::Fault { state: State::BusOff, tec: 256, rec: 0 });
        }
        up = is_up;
    }
    None
}

/// Does what the node wants with the controller, and says what came of it.
fn carry_out(action: &Action, controller: &mut MemoryController, bus: Bitrate) -> Option<Input> {
    match action {
        Action::Stop => controller.stop().ok().and(None),
        Action::Listen(candidate) => {
            controller.stop().ok()?;
            let configured = controller.configure(candidate).ok()?;
            controller.start_monitoring().ok()?;
            Some(Input::Ready(configured))
        }
        Action::TakePart(candidate) => {
            // At another rate than that of the bus it would disturb others.
            if candidate.nominal != bus {
                return None;
            }
            controller.stop().ok()?;
            let configured = controller.configure(candidate).ok()?;
            controller.start_monitoring().ok()?;
            Some(Input::Ready(configured))
        }
        Action::Send(_) => Some(Input::Sent),
        Action::Remember(_) | Action::Reset(_) => None,
    }
}
