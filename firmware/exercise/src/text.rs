//! Quantities and errors as text, and back.

use core::fmt::{self, Write};

use crate::{Sink, Source};
use canbaud::detect::scan::{Policy, UnknownPolicy};
use canbaud::lss::{LssAddress, RateSetting};
use canbaud::node::{Settings, SettingsError};
use canbaud::timing::{Request, controllers::ALL, solve};
use canbaud::units::{Bitrate, Hertz, Micros, Permille, Ppm};
use canbaud::wire::{Frame, FrameKind, Id};

impl Write for Sink {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        text.bytes().for_each(|byte| self.take(u32::from(byte)));
        Ok(())
    }
}

pub(crate) fn exercise(source: &mut Source<'_>, sink: &mut Sink) {
    // A sink takes everything: there is no error to look at.
    let _ = write(source, sink);
    let bytes = [(); 16].map(|()| source.byte());
    let text = core::str::from_utf8(&bytes).unwrap_or("500k");
    sink.take(text.parse::<Bitrate>().map_or(0, Bitrate::bits_per_second));
    sink.take_long(text.parse::<Hertz>().map_or(0, Hertz::hertz));
    sink.take(text.parse::<Policy>().map_or(0, |policy| policy as u32));
}

fn write(source: &mut Source<'_>, sink: &mut Sink) -> fmt::Result {
    write!(sink, "{} {} {}", source.bitrate(), source.clock(), source.time())?;
    write!(sink, "{} {}", Ppm(source.word() as i32), Micros(u64::from(source.word())))?;
    if let Some(permille) = Permille::new(source.word() as u16) {
        write!(sink, "{permille}")?;
    }
    let address = LssAddress::new(source.word(), source.word(), source.word(), source.word());
    write!(sink, "{address} {UnknownPolicy} {}", Policy::Koppe)?;
    write!(sink, "{}", SettingsError::TooManyRates { room: Settings::CANOPEN_RATES.len() })?;
    let rate = RateSetting::Fixed(source.bitrate());
    sink.take(u32::from(rate.index().unwrap_or(0)));
    if let Err(error) = Frame::new(Id::Base(0), FrameKind::Data, source.byte(), &[]) {
        write!(sink, "{error}")?;
    }
    let request = Request::new(source.clock(), source.bitrate());
    if let Some(controller) = ALL.get(source.byte() as usize)
        && let Err(error) = solve(&request, &controller.nominal)
    {
        write!(sink, "{error}")?;
    }
    Ok(())
}
