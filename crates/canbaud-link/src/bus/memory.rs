//! Nodes of one program.

use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use canbaud::units::Bitrate;
use canbaud::wire::Frame;

use super::FrameBus;
use crate::LinkError;

/// Frames that wait for a node that does not read; the oldest goes.
const QUEUE: usize = 4096;

#[derive(Debug)]
struct Node {
    bitrate: Bitrate,
    waiting: VecDeque<Frame>,
}

#[derive(Debug, Default)]
struct Shared {
    /// `None` where a node has left.
    nodes: Mutex<Vec<Option<Node>>>,
    news: Condvar,
}

impl Shared {
    fn nodes(&self) -> MutexGuard<'_, Vec<Option<Node>>> {
        // A panic elsewhere leaves whole frames behind.
        self.nodes.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// A bus in memory: a frame reaches all other nodes at the bit rate of its sender.
#[derive(Debug, Clone, Default)]
pub struct MemoryNet {
    shared: Arc<Shared>,
}

impl MemoryNet {
    /// A bus without nodes.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// A new node at `bitrate`; it leaves when dropped.
    #[must_use]
    pub fn join(&self, bitrate: Bitrate) -> MemoryBus {
        let mut nodes = self.shared.nodes();
        nodes.push(Some(Node { bitrate, waiting: VecDeque::new() }));
        MemoryBus { shared: Arc::clone(&self.shared), index: nodes.len() - 1 }
    }
}

/// A node of a [`MemoryNet`].
#[derive(Debug)]
pub struct MemoryBus {
    shared: Arc<Shared>,
    index: usize,
}

impl MemoryBus {
    /// Its bit rate.
    #[must_use]
    pub fn bitrate(&self) -> Option<Bitrate> {
        Some(self.shared.nodes().get(self.index)?.as_ref()?.bitrate)
    }
}

impl FrameBus for MemoryBus {
    fn send(&mut self, frame: &Frame) -> Result<(), LinkError> {
        let Some(bitrate) = self.bitrate() else { return Ok(()) };
        let mut nodes = self.shared.nodes();
        for (index, node) in nodes.iter_mut().enumerate() {
            let Some(node) = node.as_mut().filter(|node| node.bitrate == bitrate) else { continue };
            if index != self.index {
                if node.waiting.len() == QUEUE {
                    node.waiting.pop_front();
                }
                node.waiting.push_back(*frame);
            }
        }
        self.shared.news.notify_all();
        Ok(())
    }

    fn receive(&mut self, timeout: Duration) -> Result<Option<Frame>, LinkError> {
        let until = Instant::now() + timeout;
        let mut nodes = self.shared.nodes();
        loop {
            let own = nodes.get_mut(self.index).and_then(Option::as_mut);
            if let Some(frame) = own.and_then(|node| node.waiting.pop_front()) {
                return Ok(Some(frame));
            }
            let Some(left) = until.checked_duration_since(Instant::now()).filter(|d| !d.is_zero())
            else {
                return Ok(None);
            };
            let waited = self.shared.news.wait_timeout(nodes, left);
            nodes = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    fn set_bitrate(&mut self, bitrate: Bitrate) -> Result<(), LinkError> {
        if let Some(Some(node)) = self.shared.nodes().get_mut(self.index) {
            node.bitrate = bitrate;
            node.waiting.clear();
        }
        Ok(())
    }
}

impl Drop for MemoryBus {
    fn drop(&mut self) {
        if let Some(node) = self.shared.nodes().get_mut(self.index) {
            *node = None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canbaud::wire::{FrameKind, Id};

    fn frame(id: u16) -> Frame {
        Frame::new(Id::Base(id), FrameKind::Data, 1, &[7]).unwrap()
    }

    #[test]
    fn frames_reach_the_others_at_the_same_rate_only() {
        let net = MemoryNet::new();
        let [slow, fast] = [125_000, 500_000].map(|rate| Bitrate::new(rate).unwrap());
        let (mut a, mut b, mut c) = (net.join(slow), net.join(slow), net.join(fast));
        a.send(&frame(1)).unwrap();
        assert_eq!(b.receive(Duration::ZERO).unwrap(), Some(frame(1)));
        for bus in [&mut a, &mut c] {
            assert_eq!(bus.receive(Duration::ZERO).unwrap(), None);
        }
        // A change of rate throws away what was not read.
        a.send(&frame(2)).unwrap();
        b.set_bitrate(fast).unwrap();
        c.send(&frame(3)).unwrap();
        assert_eq!(b.receive(Duration::ZERO).unwrap(), Some(frame(3)));
        drop(c);
        b.send(&frame(4)).unwrap();
    }

    #[test]
    fn who_waits_is_woken() {
        let net = MemoryNet::new();
        let rate = Bitrate::new(125_000).unwrap();
        let (mut a, mut b) = (net.join(rate), net.join(rate));
        let waiting = std::thread::spawn(move || b.receive(Duration::from_secs(60)).unwrap());
        a.send(&frame(9)).unwrap();
        assert_eq!(waiting.join().unwrap(), Some(frame(9)));
    }
}
