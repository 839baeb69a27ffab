//! Rows K6, K7 and K10: the algorithm of Koppe's figure 1, and canbaud's scan on the same bus.

use canbaud::detect::scan::Evidence;
use canbaud_sim::scenario::{Run, Scenario};
use canbaud_sim::{Blind, Rng, Span, Time};

use super::bench::{plug_in, running};
use super::finding::{Finding, cells, kbits, ms};
use crate::{DeviceConfig, Listener};

/// In the order of figure 1, which begins with 10 kbit/s.
const ASCENDING: [u32; 8] = [10_000, 20_000, 50_000, 125_000, 250_000, 500_000, 800_000, 1_000_000];
/// The two modules send this often, each.
const PERIOD: Span = Span::from_ms(20);

/// What came of a search: when it ended, and how many messages and errors it looked at.
#[derive(Debug, Clone, Copy)]
struct Search {
    found: Option<Span>,
    messages: u64,
}

/// The simulator's own device with the algorithm of figure 1.
fn koppe(bitrate: u32, reconfiguration_us: u64, glitches: &str, seed: u64) -> Option<Search> {
    let rates: Vec<String> = ASCENDING.iter().map(|rate| format!("{rate}")).collect();
    let rates = rates.iter().map(|rate| format!("\"{rate}\"")).collect::<Vec<_>>().join(", ");
    let traffic = |node: &str, start: u64| {
        format!(
            "[[traffic]]\nnode = '{node}'\nkind = 'periodic'\nperiod = '20ms'\njitter = '8ms'\n\
             start = '{start}ms'\nid = {}\ndlc = 6\n",
            100 + start
        )
    };
    let text = format!(
        "title = 't'\nduration = '20s'\n\
         [[node]]\nname = 'a'\nbitrate = '{bitrate}'\n[[node]]\nname = 'b'\nbitrate = '{bitrate}'\n\
         [[node]]\nname = 'd'\nbitrate = '{bitrate}'\n\
         autobaud = {{ rates = [{rates}], reconfiguration = '{reconfiguration_us}us' }}\n{}{}{glitches}",
        traffic("a", 1),
        traffic("b", 7),
    );
    let scenario = Scenario::parse("figure-1.toml", &text).ok()?;
    let mut run = Run::new(&scenario, seed).ok()?;
    run.finish(&mut Blind);
    let node = run.statistics().nodes.get(2)?;
    let found = node.found_at_s.map(|s| Span::from_ns((s * 1e9) as u64));
    Some(Search { found, messages: node.messages })
}

/// canbaud's node with a controller that only listens, on the same kind of bus.
fn canbaud(
    bitrate: u32,
    reconfiguration: Span,
    glitch: Option<Span>,
    seed: u64,
) -> (Option<Span>, u64) {
    let mut device = DeviceConfig::automatic(5).with(Listener::Monitoring(Evidence::Errors), None);
    device.reconfiguration = reconfiguration;
    let device = device.with(Listener::Monitoring(Evidence::Errors), None);
    let (mut network, _, place) = running(bitrate, 2, PERIOD, device, seed);
    if let Some(mean) = glitch {
        let mut rng = Rng::for_purpose(seed, 5);
        let mut at = Time::ZERO;
        while at < Time::ZERO + Span::from_s(10) {
            at += Span::from_fs((rng.exponential() * mean.femtoseconds() as f64) as u64);
            let width = Span::from_fs(1 + rng.below(Span::from_us(4).femtoseconds()));
            network.sim_mut().dominant_at(at, width);
        }
    }
    let (joined, violations) = plug_in(&mut network, place, Span::ZERO, Span::from_s(9));
    (joined, network.tally().broken_silence + violations)
}

pub(super) fn k6() -> Finding {
    let mut finding = Finding::default();
    let mut rows = vec![cells![
        "bus",
        "place in the list",
        "figure 1: messages and errors",
        "figure 1: found after",
        "canbaud's scan: in after"
    ]];
    for (place, bitrate) in ASCENDING.into_iter().enumerate() {
        let Some(search) = koppe(bitrate, 100, "", 1) else { continue };
        let (joined, disturbed) = canbaud(bitrate, Span::from_us(100), None, 60);
        finding.require(joined.is_some() && disturbed == 0, format!("canbaud at {bitrate}"));
        // Far below the right rate a receiver may see two errors in one message, or none.
        if let Some(found) = search.found {
            let at_most = search.messages <= 8;
            finding.require(at_most, format!("{bitrate}: {} messages", search.messages));
            rows.push(cells![
                kbits(bitrate),
                place + 1,
                search.messages,
                ms(found),
                joined.map_or("never".into(), ms)
            ]);
        } else {
            rows.push(cells![
                kbits(bitrate),
                place + 1,
                search.messages,
                "never in 20 s",
                joined.map_or("never".into(), ms)
            ]);
        }
    }
    finding.line("Two modules that acknowledge each other, each a message every 20 ms; figure 1 from 10 kbit/s upwards, without patience:");
    finding.table(&rows);
    finding
}

pub(super) fn k7() -> Finding {
    let mut finding = Finding::default();
    let mut rows = vec![cells!["T_cc", "figure 1: found after", "canbaud's scan: in after"]];
    for us in [20, 100, 1_000, 10_000, 50_000] {
        let search = koppe(500_000, us, "", 1);
        let (joined, disturbed) = canbaud(500_000, Span::from_us(us), None, 70);
        finding.require(joined.is_some() && disturbed == 0, format!("T_cc {us} us"));
        let found = search.and_then(|s| s.found).map_or("never in 20 s".into(), ms);
        rows.push(cells![ms(Span::from_us(us)), found, joined.map_or("never".into(), ms)]);
    }
    finding.line("The same bus at 500 kbit/s:");
    finding.table(&rows);
    finding
}

pub(super) fn k10() -> Finding {
    let mut finding = Finding::default();
    let mut rows = vec![cells![
        "glitches of up to 4 µs, one every",
        "figure 1: messages, mean (fewest to most)",
        "figure 1: mean time",
        "canbaud: mean time, longest",
        "canbaud: wrong or disturbed"
    ]];
    for every in [0_u64, 20, 5, 2] {
        let glitches = match every {
            0 => String::new(),
            ms => format!(
                "[[disturbance]]\nkind = 'glitches'\nat = '0ms'\nwidth = '4us'\nevery = '{ms}ms'\nstop = '20s'\n"
            ),
        };
        let (mut messages, mut theirs, mut ours, mut disturbed) = (vec![], vec![], vec![], 0);
        for seed in 0..10 {
            if let Some(search) = koppe(500_000, 100, &glitches, seed) {
                messages.push(search.messages);
                theirs.extend(search.found);
            }
            let glitch = (every > 0).then(|| Span::from_ms(every));
            let (joined, wrong) = canbaud(500_000, Span::from_us(100), glitch, 100 + seed);
            disturbed += wrong;
            ours.extend(joined);
        }
        finding.require(ours.len() == 10 && disturbed == 0, format!("glitches every {every} ms"));
        let mean = |spans: &[Span]| {
            let sum: f64 = spans.iter().map(|span| span.seconds()).sum();
            ms(Span::from_ns((sum / spans.len().max(1) as f64 * 1e9) as u64))
        };
        let lost = 10 - theirs.len();
        let note = if lost > 0 { format!(", {lost} of 10 never") } else { String::new() };
        rows.push(cells![
            if every == 0 { "never".to_owned() } else { format!("{every} ms") },
            format!(
                "{:.1} ({} to {})",
                messages.iter().sum::<u64>() as f64 / messages.len().max(1) as f64,
                messages.iter().min().copied().unwrap_or(0),
                messages.iter().max().copied().unwrap_or(0),
            ),
            format!("{}{note}", mean(&theirs)),
            format!("{}, {}", mean(&ours), ours.iter().max().copied().map_or("never".into(), ms)),
            disturbed,
        ]);
    }
    finding.line("500 kbit/s, ten seeds each:");
    finding.table(&rows);
    finding
}
