//! What an FMU writes to the standard output: read as it comes, so that nobody waits, and forgotten
//! but for its beginning.

use std::io::Read;
use std::process::Child;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

/// Bytes of the output that are shown.
const SHOWN: usize = 80;
/// How long a reader may take once the process has ended; one that the FMU started and that got away
/// may hold the output open for ever.
const PATIENCE: Duration = Duration::from_millis(200);

/// An output being read.
pub(super) struct Output(Receiver<Vec<u8>>);

impl Output {
    pub(super) fn of(child: &mut Child) -> Self {
        let (sender, receiver) = channel();
        if let Some(mut stdout) = child.stdout.take() {
            std::thread::spawn(move || {
                let mut buffer = [0; 4096];
                let mut kept = 0;
                while let Ok(n @ 1..) = stdout.read(&mut buffer) {
                    let more = n.min(SHOWN - kept);
                    kept += more;
                    if more > 0 && sender.send(buffer[..more].to_vec()).is_err() {
                        break;
                    }
                }
            });
        }
        Self(receiver)
    }

    /// The beginning of what was written, if anything was.
    pub(super) fn taken(self) -> Option<String> {
        let mut bytes = Vec::new();
        while let Ok(more) = self.0.recv_timeout(PATIENCE) {
            bytes.extend(more);
        }
        (!bytes.is_empty()).then(|| String::from_utf8_lossy(&bytes).into_owned())
    }
}
