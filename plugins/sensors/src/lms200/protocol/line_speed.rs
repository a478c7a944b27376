//! Speeds of the line.

use rumbo_core::time::Span;

/// A speed that the device knows. Ten bits carry a byte: 8 data bits, no parity, 1 stop bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LineSpeed {
    /// 9600 baud: what the device has after power-on.
    Baud9600,
    /// 19200 baud.
    Baud19200,
    /// 38400 baud: the fastest over RS-232.
    Baud38400,
    /// 500000 baud, over RS-422 only: the one that carries every scan.
    Baud500000,
}

impl LineSpeed {
    /// In the order of the device's mode codes apart from that of power-on, which comes first.
    pub const ALL: [LineSpeed; 4] = [Self::Baud9600, Self::Baud38400, Self::Baud19200, Self::Baud500000];

    /// Bits in a second.
    pub fn baud(self) -> u32 {
        match self {
            Self::Baud9600 => 9600,
            Self::Baud19200 => 19_200,
            Self::Baud38400 => 38_400,
            Self::Baud500000 => 500_000,
        }
    }

    /// The speed of so many bits in a second, if the device has it.
    pub fn of_baud(baud: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|speed| speed.baud() == baud)
    }

    /// How long the line carries so many bytes.
    pub fn time_of(self, n_bytes: usize) -> Span {
        Span(n_bytes as i64 * 10_000_000_000 / i64::from(self.baud()))
    }

    /// In the mode command.
    pub(super) fn mode_code(self) -> u8 {
        match self {
            Self::Baud38400 => 0x40,
            Self::Baud19200 => 0x41,
            Self::Baud9600 => 0x42,
            Self::Baud500000 => 0x48,
        }
    }

    /// In the status answer: 0x8000 and the divisor of 1 MHz, less one.
    pub(super) fn status_code(self) -> u16 {
        match self {
            Self::Baud9600 => 0x8067,
            Self::Baud19200 => 0x8033,
            Self::Baud38400 => 0x8019,
            Self::Baud500000 => 0x8001,
        }
    }
}
