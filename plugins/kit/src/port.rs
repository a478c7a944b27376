//! The host's side of a line to a device: a serial port, or a bridge to one over TCP.

mod keep_open;

pub use keep_open::keep_open;

use std::io::{Error, ErrorKind, Read as _, Result, Write as _};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::time::Duration;

use rumbo_core::stages::BuildError;
use serialport::SerialPort;

/// A read waits at most so long.
const PATIENCE: Duration = Duration::from_millis(5);
/// A bridge must answer within this, and take what it is sent.
const TO_CONNECT: Duration = Duration::from_secs(2);
/// What stands before the address of a bridge.
const BRIDGE: &str = "tcp://";

/// Why a port cannot be opened, and what to do.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum PortFault {
    /// There is no such file.
    #[error("there is no such port; is the device plugged in? (`ls /dev/serial/by-id` shows what is)")]
    NotFound,
    /// It belongs to others.
    #[error(
        "no permission to open it; add yourself to the group that owns it, often `sudo usermod -aG dialout $USER`, and \
         log in anew"
    )]
    NotAllowed,
    /// Another program has it.
    #[error("another program uses it; end that one first")]
    Busy,
    /// It is a file of another kind.
    #[error("it is no serial port ({0})")]
    NotSerial(String),
    /// Nobody listens there.
    #[error("nobody listens there; is the bridge switched on, and is this its port number?")]
    NobodyListens,
    /// The name of a host is not known, or has no port number.
    #[error("the host is not known ({0}); expected tcp://host:port")]
    UnknownHost(String),
    /// Anything else.
    #[error("{0}")]
    Other(String),
}

impl PortFault {
    fn of_serial(error: &serialport::Error) -> Self {
        match error.kind {
            serialport::ErrorKind::Io(ErrorKind::NotFound) => Self::NotFound,
            serialport::ErrorKind::Io(ErrorKind::PermissionDenied) => Self::NotAllowed,
            serialport::ErrorKind::NoDevice => Self::Busy,
            serialport::ErrorKind::Unknown => Self::NotSerial(error.description.clone()),
            _ => Self::Other(error.to_string()),
        }
    }

    fn of_bridge(error: &Error) -> Self {
        match error.kind() {
            ErrorKind::ConnectionRefused => Self::NobodyListens,
            _ => Self::Other(error.to_string()),
        }
    }
}

/// An address that names something: the name of a serial port, or `tcp://host:port`.
pub fn is_address(text: &str) -> bool {
    text.strip_prefix(BRIDGE).map_or(!text.is_empty(), |host| host.rsplit_once(':').is_some())
}

/// What is wrong with the key `port` of a device, where it is given.
pub fn address_fault(port: Option<&str>) -> Option<BuildError> {
    let is_wrong = port.is_some_and(|port| !is_address(port));
    is_wrong.then(|| BuildError::at("port", "names no port, expected a serial port or tcp://host:port"))
}

/// What leads to a device.
pub enum Port {
    /// A serial port with its speed.
    Serial {
        /// The port.
        port: Box<dyn SerialPort>,
        /// Bits in a second.
        baud: u32,
    },
    /// A bridge, which has to follow the speed of the device by itself.
    Bridge(TcpStream),
}

impl Port {
    /// `tcp://host:port`, or the name of a serial port.
    pub fn open(address: &str, baud: u32) -> std::result::Result<Self, PortFault> {
        let Some(host) = address.strip_prefix(BRIDGE) else {
            // 8 data bits, no parity, 1 stop bit and no handshake are what serialport opens with.
            let opened = serialport::new(address, baud).timeout(PATIENCE).open();
            let port = opened.map_err(|error| PortFault::of_serial(&error))?;
            return Ok(Self::Serial { port, baud });
        };
        let places = host.to_socket_addrs().map_err(|error| PortFault::UnknownHost(error.to_string()))?;
        let mut last = PortFault::UnknownHost("the name has no address".to_owned());
        for place in places {
            let stream = TcpStream::connect_timeout(&place, TO_CONNECT).and_then(|stream| {
                stream.set_read_timeout(Some(PATIENCE))?;
                stream.set_write_timeout(Some(TO_CONNECT))?;
                stream.set_nodelay(true)?;
                Ok(stream)
            });
            match stream {
                Ok(stream) => return Ok(Self::Bridge(stream)),
                Err(error) => last = PortFault::of_bridge(&error),
            }
        }
        Err(last)
    }

    /// Changes the speed of a serial port and empties its buffers. A bridge has to follow by itself.
    pub fn set_baud(&mut self, wanted: u32) -> Result<()> {
        if let Self::Serial { port, baud } = self {
            port.set_baud_rate(wanted)?;
            port.clear(serialport::ClearBuffer::All)?;
            *baud = wanted;
        }
        Ok(())
    }

    /// Bits in a second, where the line has a speed.
    pub fn baud(&self) -> Option<u32> {
        match self {
            Self::Serial { baud, .. } => Some(*baud),
            Self::Bridge(_) => None,
        }
    }

    /// Sends bytes.
    pub fn send(&mut self, bytes: &[u8]) -> Result<()> {
        match self {
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
            Err(error) if is_patience(&error) => Ok(0),
            other => other,
        }
    }
}

/// Nothing came in time, which is no error.
pub(crate) fn is_patience(error: &Error) -> bool {
    matches!(error.kind(), ErrorKind::TimedOut | ErrorKind::WouldBlock | ErrorKind::Interrupted)
}

#[cfg(test)]
mod tests {
    use std::net::TcpListener;

    use super::*;

    fn fault(address: &str) -> PortFault {
        Port::open(address, 9600).err().unwrap()
    }

    #[test]
    fn what_cannot_be_opened_says_what_to_do() {
        assert_eq!(fault("/dev/no_such_port"), PortFault::NotFound);
        assert!(fault("/dev/no_such_port").to_string().contains("is the device plugged in?"));
        let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
        assert_eq!(fault(&format!("tcp://{free}")), PortFault::NobodyListens);
        assert!(matches!(fault("tcp://127.0.0.1"), PortFault::UnknownHost(_)));
    }

    /// Whoever runs the tests may be allowed everything.
    #[test]
    fn a_port_of_others_names_the_group() {
        let kind = serialport::ErrorKind::Io(ErrorKind::PermissionDenied);
        let fault = PortFault::of_serial(&serialport::Error::new(kind, "denied"));
        assert!(fault.to_string().contains("usermod -aG dialout"), "{fault}");
    }

    #[cfg(unix)]
    #[test]
    fn a_file_that_is_no_port_and_a_port_in_use_are_told_apart() {
        use serialport::SerialPort as _;
        assert!(matches!(fault("/dev/null"), PortFault::NotSerial(_)));
        let (_ours, theirs) = serialport::TTYPort::pair().unwrap();
        let name = theirs.name().unwrap();
        let _first = Port::open(&name, 9600).unwrap();
        assert_eq!(fault(&name), PortFault::Busy);
    }

    #[test]
    fn addresses_name_something() {
        for good in ["/dev/ttyUSB0", "COM3", "tcp://robot:4001"] {
            assert!(is_address(good), "{good}");
        }
        for bad in ["", "tcp://", "tcp://robot"] {
            assert!(!is_address(bad), "{bad}");
        }
    }
}
