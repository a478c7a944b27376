//! Serial ports, and bridges to them over TCP.

use std::io::{Error, ErrorKind, Read as _, Result, Write as _};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::Duration;

use serialport::SerialPort;

use crate::lms200::protocol::LineSpeed;

/// A read waits at most so long.
const PATIENCE: Duration = Duration::from_millis(5);
/// A bridge must answer within this.
const TO_CONNECT: Duration = Duration::from_secs(2);
/// At 500000 baud the device wants at least 55 µs from one byte to the next (telegram listing, chapter 3).
const BETWEEN_BYTES: Duration = Duration::from_micros(60);

/// What leads to the device.
pub(super) enum Port {
    Serial { port: Box<dyn SerialPort>, speed: LineSpeed },
    Bridge(TcpStream),
}

impl Port {
    /// `tcp://host:port`, or the name of a serial port.
    pub fn open(address: &str, speed: LineSpeed) -> Result<Self> {
        let Some(host) = address.strip_prefix("tcp://") else {
            // 8 data bits, no parity, 1 stop bit and no handshake are what serialport opens with.
            let port = serialport::new(address, speed.baud()).timeout(PATIENCE).open()?;
            return Ok(Self::Serial { port, speed });
        };
        let mut last = Error::new(ErrorKind::NotFound, "the name has no address");
        for place in host.to_socket_addrs()? {
            match TcpStream::connect_timeout(&place, TO_CONNECT) {
                Ok(stream) => {
                    stream.set_read_timeout(Some(PATIENCE))?;
                    stream.set_nodelay(true)?;
                    return Ok(Self::Bridge(stream));
                }
                Err(error) => last = error,
            }
        }
        Err(last)
    }

    /// Changes the speed of a serial port and empties its buffers. A bridge has to follow by itself.
    pub fn set_speed(&mut self, wanted: LineSpeed) -> Result<()> {
        if let Self::Serial { port, speed } = self {
            port.set_baud_rate(wanted.baud())?;
            port.clear(serialport::ClearBuffer::All)?;
            *speed = wanted;
        }
        Ok(())
    }

    /// Sends a telegram.
    pub fn send(&mut self, bytes: &[u8]) -> Result<()> {
        match self {
            Self::Serial { port, speed: LineSpeed::Baud500000 } => {
                for byte in bytes.chunks(1) {
                    port.write_all(byte)?;
                    std::thread::sleep(BETWEEN_BYTES);
                }
                Ok(())
            }
            Self::Serial { port, .. } => port.write_all(bytes),
            Self::Bridge(stream) => stream.write_all(bytes),
        }
    }

    /// Bytes that have come, perhaps none; an error when no more can come.
    pub fn receive(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let result = match self {
            Self::Serial { port, .. } => port.read(buffer),
            Self::Bridge(stream) => stream.read(buffer),
        };
        match result {
            Ok(0) => Err(Error::new(ErrorKind::UnexpectedEof, "the other side has closed the line")),
            Err(error)
                if matches!(
                    error.kind(),
                    ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted
                ) =>
            {
                Ok(0)
            }
            other => other,
        }
    }
}
