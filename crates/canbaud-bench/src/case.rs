//! A case of the benchmark with its seed, as text that repeats it.

use core::fmt;
use core::str::FromStr;

use anyhow::{Context, Result, bail};
use canbaud_sim::benchmark::{Case, PLAIN, Scene, Traffic};

/// One capture: a point of the grid, the seed that draws its frames, and how many it has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Draw {
    /// The point of the grid.
    pub case: Case,
    /// The seed.
    pub seed: u64,
    /// Frames that are asked for.
    pub frames: u32,
}

/// Words for scenes.
#[must_use]
pub fn scene_name(scene: Scene) -> String {
    match scene {
        Scene::Acknowledged => "acknowledged".into(),
        Scene::Unacknowledged => "unacknowledged".into(),
        Scene::ErrorFlags => "error-flags".into(),
        Scene::Babbler => "babbler".into(),
        Scene::Glitches(count) => format!("glitches-{count}"),
        Scene::Inverted => "inverted".into(),
        Scene::Stuck => "stuck".into(),
        Scene::OneFrame => "one-frame".into(),
    }
}

fn scene(text: &str) -> Result<Scene> {
    if let Some(count) = text.strip_prefix("glitches-") {
        return Ok(Scene::Glitches(count.parse()?));
    }
    let all = canbaud_sim::benchmark::SCENES;
    let found = all.into_iter().find(|scene| scene_name(*scene) == text);
    found.with_context(|| {
        let names: Vec<_> = all.into_iter().map(scene_name).collect();
        format!("no scene \"{text}\", there are: {}", names.join(", "))
    })
}

/// Words for kinds of frames.
#[must_use]
pub fn traffic_name(traffic: Traffic) -> String {
    match traffic {
        Traffic::Classic => "classic".into(),
        Traffic::Fd => "fd".into(),
        Traffic::FdBrs(rate) => format!("fd-{rate}"),
        Traffic::FdBrsNonIso(rate) => format!("fd-non-iso-{rate}"),
    }
}

fn traffic(text: &str) -> Result<Traffic> {
    match text {
        "classic" => return Ok(Traffic::Classic),
        "fd" => return Ok(Traffic::Fd),
        _ => {}
    }
    if let Some(rate) = text.strip_prefix("fd-non-iso-") {
        Ok(Traffic::FdBrsNonIso(rate.parse()?))
    } else if let Some(rate) = text.strip_prefix("fd-") {
        Ok(Traffic::FdBrs(rate.parse()?))
    } else {
        bail!("no traffic \"{text}\", there are: classic, fd, fd-RATE, fd-non-iso-RATE")
    }
}

/// What differs from the plain case, the seed and the number of frames: `timer=2000000,seed=7,frames=8`.
impl fmt::Display for Draw {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (case, plain) = (&self.case, &PLAIN);
        let mut field = |differs: bool, name: &str, value: &dyn fmt::Display| {
            if differs { write!(f, "{name}={value},") } else { Ok(()) }
        };
        field(case.bitrate != plain.bitrate, "bitrate", &case.bitrate)?;
        field(case.timer_hz != plain.timer_hz, "timer", &case.timer_hz)?;
        field(case.asymmetry_ns != plain.asymmetry_ns, "asymmetry", &case.asymmetry_ns)?;
        field(case.jitter_ns != plain.jitter_ns, "jitter", &case.jitter_ns)?;
        field(case.ppm != plain.ppm, "ppm", &case.ppm)?;
        field(case.load_permille != plain.load_permille, "load", &case.load_permille)?;
        field(case.scene != plain.scene, "scene", &scene_name(case.scene))?;
        field(case.traffic != plain.traffic, "traffic", &traffic_name(case.traffic))?;
        write!(f, "seed={},frames={}", self.seed, self.frames)
    }
}

impl FromStr for Draw {
    type Err = anyhow::Error;

    fn from_str(text: &str) -> Result<Self> {
        let mut draw = Self { case: PLAIN, seed: 0, frames: 1 };
        for part in text.split(',') {
            let (name, value) =
                part.split_once('=').with_context(|| format!("\"{part}\" is not NAME=VALUE"))?;
            let case = &mut draw.case;
            match name {
                "bitrate" => case.bitrate = value.parse()?,
                "timer" => case.timer_hz = value.parse()?,
                "asymmetry" => case.asymmetry_ns = value.parse()?,
                "jitter" => case.jitter_ns = value.parse()?,
                "ppm" => case.ppm = value.parse()?,
                "load" => case.load_permille = value.parse()?,
                "scene" => case.scene = scene(value)?,
                "traffic" => case.traffic = traffic(value)?,
                "seed" => draw.seed = value.parse()?,
                "frames" => draw.frames = value.parse()?,
                _ => bail!(
                    "no \"{name}\", there are: bitrate, timer, asymmetry, jitter, ppm, load, \
                     scene, traffic, seed, frames"
                ),
            }
        }
        Ok(draw)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use canbaud_sim::benchmark::{SCENES, TRAFFIC};

    #[test]
    fn every_case_is_read_back_from_its_text() {
        let mut cases = canbaud_sim::benchmark::grid();
        cases.extend(SCENES.map(|scene| Case { scene, ..PLAIN }));
        cases.extend(TRAFFIC.map(|traffic| Case { traffic, jitter_ns: 50, ..PLAIN }));
        for (seed, case) in (1..).zip(cases) {
            let draw = Draw { case, seed, frames: 12 };
            assert_eq!(draw.to_string().parse::<Draw>().unwrap(), draw, "{draw}");
        }
    }

    #[test]
    fn mistakes_are_named() {
        for (text, want) in
            [("timer", "NAME=VALUE"), ("clock=1", "bitrate, timer"), ("scene=x", "babbler")]
        {
            let error = text.parse::<Draw>().unwrap_err().to_string();
            assert!(error.contains(want), "{error}");
        }
    }
}
