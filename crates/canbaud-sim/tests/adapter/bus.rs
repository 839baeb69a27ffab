//! The bus that the tests of the adapter talk to.

use canbaud_sim::slcan::{Adapter, Entry, Firmware};
use canbaud_sim::{Mode, NodeConfig, NodeId, Simulation, Span, Stop, Time};

use crate::common::data;

/// A bus with two talkers and an adapter.
pub(crate) struct Bus {
    pub(crate) sim: Simulation,
    pub(crate) adapter: Adapter,
    pub(crate) talkers: [NodeId; 2],
    /// How often the adapter drove the bus dominant.
    pub(crate) dominant: u64,
}

struct Dominant<'a>(NodeId, &'a mut u64);

impl canbaud_sim::Observer for Dominant<'_> {
    fn txd(&mut self, _: Time, node: NodeId, level: canbaud::wire::Level) {
        *self.1 += u64::from(node == self.0 && level == canbaud::wire::Level::Dominant);
    }
}

/// Two talkers at `bitrate`, and an adapter as it comes out of its box.
pub(crate) fn at(bitrate: u32, firmware: Firmware) -> Bus {
    let config = NodeConfig::at("talker", bitrate).unwrap();
    of(config.with_data_bitrate(2_000_000).unwrap(), firmware)
}

/// Two talkers of that kind.
pub(crate) fn of(talker: NodeConfig, firmware: Firmware) -> Bus {
    let mut sim = Simulation::new(1);
    let talkers = [0, 1].map(|_| sim.add_node(talker.clone()).unwrap());
    let config = NodeConfig::at("adapter", 500_000).unwrap();
    let id = sim.add_node(config.clone().with_mode(Mode::Disabled)).unwrap();
    sim.watch(id);
    Bus { sim, adapter: Adapter::new(id, config, firmware), talkers, dominant: 0 }
}

impl Bus {
    /// Commands separated by blanks; what the adapter answers, CR as `;` and BELL as `!`.
    pub(crate) fn says(&mut self, commands: &str) -> String {
        for command in commands.split(' ') {
            self.adapter.command(format!("{command}\r").as_bytes(), &mut self.sim);
        }
        self.output()
    }

    pub(crate) fn output(&mut self) -> String {
        String::from_utf8(self.adapter.take_output())
            .unwrap()
            .replace('\r', ";")
            .replace('\x07', "!")
    }

    pub(crate) fn run_ms(&mut self, ms: u64) -> String {
        let until = self.sim.now() + Span::from_ms(ms);
        loop {
            let mut observer = Dominant(self.adapter.node(), &mut self.dominant);
            let stop = self.sim.run(until, &mut observer);
            for (at, _, event) in self.sim.take_news() {
                self.adapter.notice(at, &event, &self.sim);
            }
            if stop == Stop::Reached {
                return self.output();
            }
        }
    }

    pub(crate) fn talk(&mut self, count: u64) {
        for n in 0..count {
            let at = self.sim.now() + Span::from_us(500 + 1_000 * n);
            self.sim.send_at(at, self.talkers[0], data(0x123, &[0xDE, 0xAD, n as u8]));
        }
    }

    /// Every line of the log, without its time.
    pub(crate) fn log(&self) -> Vec<String> {
        let line = |entry: &Entry| entry.to_string().split_once(' ').unwrap().1.to_owned();
        self.adapter.log().iter().map(line).collect()
    }
}
