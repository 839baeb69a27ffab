//! Serial ports that may be slcan adapters; nothing is sent to them.

use std::fs;
use std::path::{Path, PathBuf};

use serial2::SerialPort;

/// A serial port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SerialAdapter {
    /// Its path.
    pub port: PathBuf,
    /// Vendor and product number, if it is a USB device.
    pub usb: Option<(u16, u16)>,
    /// What the device calls itself.
    pub product: Option<String>,
    /// What is known of these numbers.
    pub known: Option<&'static str>,
}

/// Numbers of adapters that speak slcan.
const KNOWN: &[((u16, u16), &str)] = &[
    ((0xAD50, 0x60C4), "CANable 1.x or CANtact, slcan firmware: has no listen-only that is sure"),
    ((0x16D0, 0x117E), "CANable 2.0, slcan firmware: the maker's has no listen-only that is sure"),
    ((0x0403, 0xFFA8), "Lawicel CANUSB"),
    ((0x04D8, 0x000A), "USBtin, or another device with a Microchip serial port"),
];

/// The serial ports of this machine that a USB device is behind, and others that are in use.
#[must_use]
pub fn serial_adapters() -> Vec<SerialAdapter> {
    let mut ports = SerialPort::available_ports().unwrap_or_default();
    ports.sort();
    let adapter = |port| SerialAdapter::of(Path::new("/sys"), port);
    // Serial ports of the board are always listed, connected or not.
    ports
        .into_iter()
        .map(adapter)
        .filter(|adapter| cfg!(not(target_os = "linux")) || adapter.usb.is_some())
        .collect()
}

impl SerialAdapter {
    /// Reads what there is below `sys`, which is `/sys` but for tests.
    fn of(sys: &Path, port: PathBuf) -> Self {
        let device = port.file_name().map(|name| sys.join("class/tty").join(name).join("device"));
        // The tty hangs on an interface of the USB device, or on a port of one.
        let above = ["..", "../.."].map(|up| device.as_ref().map(|device| device.join(up)));
        let text = |name: &str| {
            above.iter().flatten().find_map(|above| fs::read_to_string(above.join(name)).ok())
        };
        let number = |name| u16::from_str_radix(text(name)?.trim(), 16).ok();
        let usb = number("idVendor").zip(number("idProduct"));
        let product = text("product").map(|text| text.trim().to_owned());
        let known = KNOWN.iter().find(|known| Some(known.0) == usb).map(|known| known.1);
        Self { port, usb, product, known }
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    #[test]
    fn a_canable_is_known_by_its_numbers() {
        let root = std::env::temp_dir().join(format!("canbaud-serial-{}", std::process::id()));
        let interface = root.join("devices/usb1/1-1/1-1:1.0");
        fs::create_dir_all(interface.join("tty/ttyACM0")).unwrap();
        fs::create_dir_all(root.join("class/tty/ttyACM0")).unwrap();
        std::os::unix::fs::symlink(&interface, root.join("class/tty/ttyACM0/device")).unwrap();
        for (name, text) in
            [("idVendor", "ad50\n"), ("idProduct", "60c4\n"), ("product", "CANable\n")]
        {
            fs::write(root.join("devices/usb1/1-1").join(name), text).unwrap();
        }
        let adapter = SerialAdapter::of(&root, PathBuf::from("/dev/ttyACM0"));
        assert_eq!(adapter.usb, Some((0xAD50, 0x60C4)));
        assert_eq!(adapter.product.as_deref(), Some("CANable"));
        assert!(adapter.known.unwrap().starts_with("CANable 1.x"));
        let none = SerialAdapter::of(&root, PathBuf::from("/dev/ttyS0"));
        assert_eq!((none.usb, none.known), (None, None));
        fs::remove_dir_all(root).unwrap();
    }
}
