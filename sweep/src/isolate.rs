//! Runs in processes of their own, so that an FMU that crashes takes one run with it and no more.
//!
//! The parent writes the number of a run as a line; the child answers with a line: `ready` and the
//! study's hash once at its start, then for each run `row` and the row of the results, or `stopped`.
//! Other lines are what the FMUs print, and are passed over. A child whose FMU has ended fatally
//! answers `last` instead of `row` and goes; the next run gets another. One that does not answer in time is
//! ended by the parent.

use crate::Error;
use crate::make::{Made, Options, too_long};
use crate::metric::Outcome;
use crate::prepare::Sweep;
use crate::results::{row, row_of_line};
use crate::rig::Rig;
use crate::watch::{Watch, held};
use std::io::{BufRead, BufReader, Write};
use std::process::{ChildStdin, ChildStdout, Command, Stdio};
use std::sync::atomic::Ordering;
use std::sync::{Arc, Mutex};
use std::time::Instant;
use steerwright_host::process::Subprocess;

const READY: &str = "steerwright sweep ready ";
const ROW: &str = "steerwright sweep row ";
const LAST: &str = "steerwright sweep last ";
const STOPPED: &str = "steerwright sweep stopped";

/// A thread's process, if one is running.
pub(crate) struct Worker<'a> {
    start: &'a (dyn Fn() -> Command + Sync),
    running: Option<Running>,
}

struct Running {
    /// Shared with the watch, which may end it.
    process: Arc<Mutex<Subprocess>>,
    to: ChildStdin,
    from: BufReader<ChildStdout>,
}

impl<'a> Worker<'a> {
    pub(crate) fn new(start: &'a (dyn Fn() -> Command + Sync)) -> Self {
        Self { start, running: None }
    }

    /// Has a run made; where the process ends over it, its row has the reason.
    pub(crate) fn make(
        &mut self,
        sweep: &Sweep,
        run: usize,
        options: &Options<'_>,
        watched: Option<(&Watch, usize)>,
    ) -> Result<Made, Error> {
        let stopped = Made { row: None, fatal: None };
        let watch = |process: &Arc<Mutex<Subprocess>>| {
            if let Some((watch, thread)) = watched {
                watch.begin(thread, run, Some(Arc::clone(process)));
            }
        };
        let start = || match Running::start((self.start)(), &sweep.id, watch) {
            // One that has to stop may be gone before it is ready.
            Err(_) if options.stop.load(Ordering::Relaxed) => Ok(None),
            started => started.map(Some),
        };
        let kept = match self.running.take() {
            Some(mut running) => running.request(run).map(|()| running),
            None => None,
        };
        let mut running = match kept {
            Some(running) => running,
            // There is none, or it has ended since its last answer.
            None => {
                let Some(mut running) = start()? else { return Ok(stopped) };
                let _ = running.request(run);
                running
            }
        };
        let begun = Instant::now();
        watch(&running.process);
        match running.answer() {
            Some(line) if line.starts_with(STOPPED) => Ok(stopped),
            Some(line) => {
                let goes_on = line.starts_with(ROW);
                let line = line.strip_prefix(if goes_on { ROW } else { LAST }).unwrap_or_default();
                let outcome =
                    row_of_line(sweep, run, line).map_err(|reason| Error::Process { reason })?;
                let row = Some((outcome, line.as_bytes().to_vec()));
                self.running = if goes_on { Some(running) } else { None };
                Ok(Made { row, fatal: None })
            }
            // A process that has to stop may be gone before it can answer.
            None if options.stop.load(Ordering::Relaxed) => Ok(stopped),
            None => {
                let ended = running.end();
                let outcome = Outcome::Failed(match options.timeout {
                    Some(limit) if begun.elapsed() > limit => too_long(options),
                    _ => format!("error: the process ended: {ended}"),
                });
                let bytes = row(sweep, run, &sweep.plan.quantities(run), &outcome);
                Ok(Made { row: Some((outcome, bytes)), fatal: None })
            }
        }
    }
}

impl Running {
    /// `watch` is given the process as soon as it runs.
    fn start(
        mut command: Command,
        id: &str,
        watch: impl FnOnce(&Arc<Mutex<Subprocess>>),
    ) -> Result<Self, Error> {
        let failed = |reason: String| Error::Process { reason };
        let mut process =
            Subprocess::start(command.stdout(Stdio::piped())).map_err(|e| failed(e.to_string()))?;
        let (Some(to), Some(from)) = (process.take_input(), process.child().stdout.take()) else {
            return Err(failed("it has no pipes".to_owned()));
        };
        let process = Arc::new(Mutex::new(process));
        watch(&process);
        let mut running = Self { process, to, from: BufReader::new(from) };
        match running.answer() {
            Some(line) if line.strip_prefix(READY).map(str::trim_end) == Some(id) => Ok(running),
            // It waits for runs: dropped, it is ended.
            Some(_) => Err(failed("study or FMUs have changed meanwhile".to_owned())),
            None => Err(failed(format!("it ended: {}", running.end()))),
        }
    }

    fn request(&mut self, run: usize) -> Option<()> {
        writeln!(self.to, "{run}").and_then(|()| self.to.flush()).ok()
    }

    /// The next line that is an answer; `None` where the process has ended.
    fn answer(&mut self) -> Option<String> {
        let mut bytes = Vec::new();
        loop {
            bytes.clear();
            if self.from.read_until(b'\n', &mut bytes).ok()? == 0 {
                return None;
            }
            let line = String::from_utf8_lossy(&bytes);
            if [READY, ROW, LAST, STOPPED].iter().any(|start| line.starts_with(start)) {
                return if line.ends_with('\n') { Some(line.into_owned()) } else { None };
            }
        }
    }

    /// Waits for its end, and returns its status.
    fn end(&mut self) -> String {
        let ended = held(&self.process).child().wait();
        ended.map_or_else(|e| e.to_string(), |status| status.to_string())
    }
}

impl Sweep {
    /// Makes the runs that `input` names, a line each, and answers on `output`: the other side of
    /// [`Options::isolate`]. Of the options, trajectories and stop count.
    pub fn serve(
        &self,
        options: &Options<'_>,
        input: impl IntoIterator<Item = String>,
        mut output: impl Write,
    ) -> Result<(), Error> {
        let mut rig = Rig::new(&self.plan, self.source.archives());
        let closed = |e: std::io::Error| Error::Process { reason: format!("its parent: {e}") };
        let mut answer = |text: &str| {
            writeln!(output, "{}", text.trim_end()).and_then(|()| output.flush()).map_err(closed)
        };
        answer(&format!("{READY}{}", self.id))?;
        for line in input {
            let Some(run) = line.trim().parse().ok().filter(|run| *run < self.runs()) else {
                return Err(Error::Process { reason: format!("{line:?} is no run") });
            };
            let made = self.make_here(&mut rig, options, run)?;
            match made.row {
                Some((_, bytes)) => {
                    let what = if made.fatal.is_some() { LAST } else { ROW };
                    answer(&format!("{what}{}", String::from_utf8_lossy(&bytes)))?;
                }
                None => return answer(STOPPED),
            }
            if made.fatal.is_some() {
                break;
            }
        }
        Ok(())
    }
}
