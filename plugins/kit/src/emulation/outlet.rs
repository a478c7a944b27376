//! Where a host finds an emulated device: a pseudo-terminal, or a port of TCP.

use std::io::{Error, Read as _, Result, Write as _};
use std::net::{TcpListener, TcpStream};
use std::time::Duration;

#[cfg(unix)]
use serialport::{SerialPort as _, TTYPort};

use crate::port::is_patience;

/// A read waits at most so long: the device goes on in the meantime.
const PATIENCE: Duration = Duration::from_millis(2);
/// A pseudo-terminal says that there is room, but not how much, and a write of more than that would wait for ever: so
/// few bytes fit into any room that it has.
#[cfg(unix)]
const BYTES_AT_ONCE: usize = 64;
/// While nobody is there, look again after this.
const LOOK: Duration = Duration::from_millis(5);

/// Where a host finds an emulated device.
pub enum Outlet {
    /// A pseudo-terminal: its other side is opened like a serial port, and has a speed.
    #[cfg(unix)]
    Terminal {
        /// The side of the device.
        ours: TTYPort,
        /// Name of the other side.
        name: String,
    },
    /// A port of TCP, one host at a time.
    Tcp {
        /// Takes hosts.
        listener: TcpListener,
        /// The host that is there.
        host: Option<TcpStream>,
    },
}

impl Outlet {
    /// A new pseudo-terminal.
    #[cfg(unix)]
    pub fn terminal() -> Result<Self> {
        let (mut ours, theirs) = TTYPort::pair()?;
        let name = theirs.name().ok_or_else(|| Error::other("the pseudo-terminal has no name"))?;
        ours.set_timeout(PATIENCE)?;
        Ok(Self::Terminal { ours, name })
    }

    /// A port of TCP at `address`, such as `127.0.0.1:4001`; port 0 is any that is free.
    pub fn tcp(address: &str) -> Result<Self> {
        let listener = TcpListener::bind(address)?;
        listener.set_nonblocking(true)?;
        Ok(Self::Tcp { listener, host: None })
    }

    /// A new pseudo-terminal where there are such, else a free port of TCP on this machine.
    pub fn any() -> Result<Self> {
        #[cfg(unix)]
        return Self::terminal();
        #[cfg(not(unix))]
        return Self::tcp("127.0.0.1:0");
    }

    /// What a host opens: the name of a serial port, or `tcp://host:port`.
    pub fn address(&self) -> String {
        match self {
            #[cfg(unix)]
            Self::Terminal { name, .. } => name.clone(),
            Self::Tcp { listener, .. } => {
                listener.local_addr().map_or_else(|error| error.to_string(), |at| format!("tcp://{at}"))
            }
        }
    }

    /// The speed that the host has given its port, where ports have speeds.
    pub fn baud(&self) -> Option<u32> {
        match self {
            #[cfg(unix)]
            Self::Terminal { ours, .. } => ours.baud_rate().ok(),
            Self::Tcp { .. } => None,
        }
    }

    /// Bytes that have come; nothing where no host is there. Waits a little for them.
    pub fn receive(&mut self, buffer: &mut [u8]) -> Option<usize> {
        let received = match self {
            #[cfg(unix)]
            Self::Terminal { ours, .. } => ours.read(buffer),
            Self::Tcp { listener, host } => {
                if host.is_none() {
                    *host = listener.accept().and_then(|(stream, _)| prepared(stream)).ok();
                }
                host.as_mut().map_or_else(|| Err(Error::other("nobody is there")), |host| host.read(buffer))
            }
        };
        match received {
            Ok(n_bytes) if n_bytes > 0 => Some(n_bytes),
            Err(error) if is_patience(&error) => Some(0),
            _ => {
                self.hang_up();
                std::thread::sleep(LOOK);
                None
            }
        }
    }

    /// Sends bytes, and says how many the line did not take in time: they are lost.
    pub fn send(&mut self, mut bytes: &[u8]) -> usize {
        while !bytes.is_empty() {
            let sent = match self {
                #[cfg(unix)]
                Self::Terminal { ours, .. } => ours.write(bytes.get(..BYTES_AT_ONCE).unwrap_or(bytes)),
                Self::Tcp { host: Some(host), .. } => host.write(bytes),
                Self::Tcp { host: None, .. } => return bytes.len(),
            };
            let Ok(n_bytes @ 1..) = sent else { return bytes.len() };
            bytes = bytes.get(n_bytes..).unwrap_or_default();
        }
        0
    }

    /// The host is sent away; a pseudo-terminal cannot do that.
    pub fn hang_up(&mut self) {
        if let Self::Tcp { host, .. } = self {
            *host = None;
        }
    }
}

fn prepared(stream: TcpStream) -> Result<TcpStream> {
    stream.set_nonblocking(false)?;
    stream.set_nodelay(true)?;
    stream.set_read_timeout(Some(PATIENCE))?;
    stream.set_write_timeout(Some(PATIENCE))?;
    Ok(stream)
}
