//! Processes that run FMUs: each ends with its parent, however that ends.
//!
//! The standard input of such a process is a pipe whose other end its parent alone holds. The system closes it when
//! the parent ends, and a thread of the process, which waits for that, ends the process; also where an FMU
//! does not return, and without a moment in which the end of the parent goes unnoticed. Where the process needs the
//! standard input of its parent, the pipe is another descriptor. Temporary files of the process are in a folder of
//! its parent.

use crate::scratch::Scratch;
use std::io::{BufRead, Read};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};

/// The variable with the descriptor of the pipe, where that is not the standard input.
#[cfg(unix)]
const PIPE_OF_PARENT: &str = "STEERWRIGHT_PIPE_OF_PARENT";

/// A process that ends with this one, and takes what it started with it.
#[derive(Debug)]
pub struct Subprocess {
    child: Child,
    /// Closed when this value is dropped or this process ends.
    pipe: Option<Pipe>,
    folder: Scratch,
}

/// The end of a process's pipe that its parent holds.
#[derive(Debug)]
enum Pipe {
    Input(ChildStdin),
    #[cfg(unix)]
    Other {
        /// Held, never written to.
        _writer: std::io::PipeWriter,
    },
}

impl Subprocess {
    /// Starts a program that calls [`end_with_parent`] or [`lines_of_parent`]. `command` has no standard input yet.
    pub fn start(command: &mut Command) -> std::io::Result<Self> {
        command.stdin(Stdio::piped());
        // That of this process is not its own.
        #[cfg(unix)]
        command.env_remove(PIPE_OF_PARENT);
        let mut process = Self::start_with_pipe(command, None)?;
        process.pipe = process.child.stdin.take().map(Pipe::Input);
        Ok(process)
    }

    /// Starts a program that calls [`end_with_parent`] and reads the standard input of this process.
    #[cfg(unix)]
    pub fn start_with_input(command: &mut Command) -> std::io::Result<Self> {
        use std::os::fd::AsRawFd;
        let (reader, writer) = std::io::pipe()?;
        // The process inherits it. Another that is started at this moment inherits the reading end alone, which
        // keeps nothing open.
        rustix::io::fcntl_setfd(&reader, rustix::io::FdFlags::empty())?;
        command.env(PIPE_OF_PARENT, reader.as_raw_fd().to_string()).stdin(Stdio::inherit());
        Self::start_with_pipe(command, Some(Pipe::Other { _writer: writer }))
    }

    /// Where there is one pipe, it is the standard input.
    #[cfg(not(unix))]
    pub fn start_with_input(command: &mut Command) -> std::io::Result<Self> {
        Self::start(command)
    }

    fn start_with_pipe(command: &mut Command, pipe: Option<Pipe>) -> std::io::Result<Self> {
        let folder = Scratch::new()?;
        for variable in ["TMPDIR", "TMP", "TEMP"] {
            command.env(variable, folder.path());
        }
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        Ok(Self { child: command.spawn()?, pipe, folder })
    }

    /// The folder of its temporary files; removed with this value.
    #[must_use]
    pub fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// The process, for its output and its status.
    pub fn child(&mut self) -> &mut Child {
        &mut self.child
    }

    /// Its standard input, for [`lines_of_parent`]; what takes it keeps the process running.
    pub fn take_input(&mut self) -> Option<ChildStdin> {
        match self.pipe.take() {
            Some(Pipe::Input(input)) => Some(input),
            other => {
                self.pipe = other;
                None
            }
        }
    }

    /// A function that asks it to end, or with `true` ends it and what it started; for
    /// [`on_interruption`] while another thread waits for it. Where an interruption reaches all processes of a
    /// terminal by itself, as on Windows, it does nothing.
    pub fn interrupter(&self) -> impl Fn(bool) + Send + 'static {
        #[cfg(unix)]
        let process = i32::try_from(self.child.id()).ok().and_then(rustix::process::Pid::from_raw);
        move |at_once| {
            #[cfg(unix)]
            if let Some(process) = process {
                use rustix::process::{Signal, kill_process, kill_process_group};
                // An error means that it has ended.
                let _ = if at_once {
                    kill_process_group(process, Signal::KILL)
                } else {
                    kill_process(process, Signal::TERM)
                };
            }
            #[cfg(not(unix))]
            let _ = at_once;
        }
    }

    /// Ends it and what it started. One that has just ended by itself is no error.
    pub fn kill(&mut self) {
        #[cfg(unix)]
        if let Some(group) =
            i32::try_from(self.child.id()).ok().and_then(rustix::process::Pid::from_raw)
        {
            // An error means that the group is empty.
            let _ = rustix::process::kill_process_group(group, rustix::process::Signal::KILL);
        }
        let _ = self.child.kill();
    }
}

impl Drop for Subprocess {
    fn drop(&mut self) {
        // Also of one that has ended: what it started is still in its group.
        self.kill();
        let _ = self.child.wait();
    }
}

/// Ends this process as soon as its parent ends or closes the pipe, which is the standard input or that of
/// [`Subprocess::start_with_input`].
pub fn end_with_parent() -> std::io::Result<()> {
    let mut input = pipe_of_parent()?;
    std::thread::Builder::new().name("parent".into()).spawn(move || {
        let mut nothing = [0; 64];
        while input.read(&mut nothing).is_ok_and(|count| count > 0) {}
        end();
    })?;
    Ok(())
}

/// The lines that the parent writes to the standard input; this process ends as with [`end_with_parent`].
pub fn lines_of_parent() -> std::io::Result<Receiver<String>> {
    let input = taken_input()?;
    let (sender, receiver) = channel();
    std::thread::Builder::new().name("parent".into()).spawn(move || {
        let mut lines = std::io::BufReader::new(input).lines();
        while let Some(Ok(line)) = lines.next() {
            // Whoever does not listen any more is about to end.
            let _ = sender.send(line);
        }
        end();
    })?;
    Ok(receiver)
}

#[cfg(unix)]
#[allow(unsafe_code)]
fn pipe_of_parent() -> std::io::Result<std::fs::File> {
    let stated = std::env::var(PIPE_OF_PARENT).ok().and_then(|text| text.parse().ok());
    let Some(descriptor) = stated.filter(|descriptor| *descriptor > 2) else {
        return taken_input();
    };
    // SAFETY: the process has inherited it open, and nothing closes it.
    let pipe = unsafe { std::os::fd::BorrowedFd::borrow_raw(descriptor) };
    Ok(rustix::io::fcntl_dupfd_cloexec(pipe, 3)?.into())
}

#[cfg(not(unix))]
fn pipe_of_parent() -> std::io::Result<std::io::Stdin> {
    taken_input()
}

/// The standard input, out of the reach of FMUs: they find it empty.
#[cfg(unix)]
fn taken_input() -> std::io::Result<std::fs::File> {
    let taken = rustix::io::fcntl_dupfd_cloexec(rustix::stdio::stdin(), 3)?;
    rustix::stdio::dup2_stdin(std::fs::File::open("/dev/null")?)?;
    Ok(taken.into())
}

#[cfg(not(unix))]
fn taken_input() -> std::io::Result<std::io::Stdin> {
    Ok(std::io::stdin())
}

/// Ends this process at once; on Unix also what it started.
fn end() -> ! {
    #[cfg(unix)]
    {
        use rustix::process::{Signal, getpgrp, getpid, kill_current_process_group, kill_process};
        if getpgrp() == getpid() {
            let _ = kill_current_process_group(Signal::KILL);
        }
        let _ = kill_process(getpid(), Signal::KILL);
    }
    // Runs nothing at exit, which could wait for the thread of an FMU.
    std::process::abort()
}

/// Has a function called when this process is asked to end: Ctrl-C, and on Unix SIGTERM and SIGHUP; a SIGHUP that is
/// ignored, as `nohup` has it, stays ignored. A process has one such function.
pub fn on_interruption(act: impl FnMut() + 'static + Send) -> Result<(), ctrlc::Error> {
    #[cfg(unix)]
    let is_ignored = hangup_is_ignored();
    ctrlc::set_handler(act)?;
    #[cfg(unix)]
    if is_ignored {
        ignore_hangup();
    }
    Ok(())
}

#[cfg(unix)]
#[allow(unsafe_code)]
fn hangup_is_ignored() -> bool {
    let mut action = std::mem::MaybeUninit::<libc::sigaction>::zeroed();
    // SAFETY: without a new action the call only writes the present one to memory of its type, of which all zeros
    // are a value.
    let action = unsafe {
        libc::sigaction(libc::SIGHUP, std::ptr::null(), action.as_mut_ptr());
        action.assume_init()
    };
    action.sa_sigaction == libc::SIG_IGN
}

#[cfg(unix)]
#[allow(unsafe_code)]
fn ignore_hangup() {
    // SAFETY: no function is installed, so nothing of this program runs in a signal handler.
    unsafe { libc::signal(libc::SIGHUP, libc::SIG_IGN) };
}
