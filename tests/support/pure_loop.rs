//! The steering loop of the pure functions, without FMU, archive or importer: the trajectory that
//! every importer is compared with.
//!
//! The three models are driven as an importer drives FMUs: inputs set, outputs read, steps taken,
//! under either coupling and after the initialization of that importer. Importers differ in what
//! reaches an input before the first step, and the controller's tick 0 sees that.

use std::fmt::Write;
use std::sync::Arc;
use steerwright_formats::{LoopCoupling, Path, Pid as PidFile, Plant};
use steerwright_models::{
    GuidanceParameters, IdentifiedPlant, PathFollower, PathOutput, Pid, PidInput, PidOutput,
    PidParameters,
};

/// What passes through the connections before the first step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(dead_code)] // not each importer's tests need each
pub(crate) enum Initialization {
    /// Values are passed on in initialization mode until none changes, as by libcosim and by the
    /// importers that step instances one by one. An FMU container passes them on once, in the order
    /// plant, path, controller, which settles this loop as well.
    Settled,
    /// Nothing is read, and the inputs of the first step are 0, as by fmpy's `simulate_ssp`.
    Zeros,
}

/// The columns of a trajectory, after the time.
pub(crate) const COLUMNS: [&str; 12] = [
    "IdentifiedPlant.x",
    "IdentifiedPlant.y",
    "IdentifiedPlant.yaw",
    "IdentifiedPlant.yaw_rate",
    "ReferencePath.yaw_reference",
    "ReferencePath.steering_feedforward",
    "ReferencePath.cross_track_error",
    "ReferencePath.heading_error",
    "ReferencePath.curvature",
    "ReferencePath.distance",
    "LateralPid.steering_angle",
    "LateralPid.saturated",
];

/// What stands on the connections and the other outputs.
#[derive(Default, Clone, Copy)]
struct Signals {
    pose: [f64; 3],
    yaw_rate: f64,
    path: PathOutput,
    steering: PidOutput,
}

/// The behaviour of a unit, as in its FMU's README.
struct Units {
    plant: IdentifiedPlant,
    law: GuidanceParameters,
    follower: PathFollower,
    speed: f64,
    pose: [f64; 3],
    parameters: PidParameters,
    controller: Pid,
    input: PidInput,
    /// Whether the controller's yaw and yaw reference were ever set.
    given: bool,
    /// Inputs of path and controller at their last read, which the first step commits.
    last_read: ([f64; 3], PidInput, bool),
    running: Option<(PathOutput, PidOutput)>,
}

impl Units {
    fn new(plant: &Plant, path: &Path, pid: &PidFile) -> Self {
        let model = steerwright_models::files::identified_model(plant).unwrap();
        let mut plant = IdentifiedPlant::new(Arc::new(model));
        let first = path.points[0];
        let pose = [first.x_m, first.y_m, first.heading_rad];
        [plant.initial_x, plant.initial_y, plant.initial_yaw] = pose;
        plant.speed = path.speed_mps;
        plant.start();
        let geometry = steerwright_models::files::path_geometry(path).unwrap();
        // No one connects the speed of the controller's limits: it is the road's, as packed.
        let speed = path.speed_mps;
        let input = PidInput { enabled: true, speed, ..PidInput::default() };
        Self {
            plant,
            law: steerwright_models::files::guidance_parameters(&path.guidance, path.speed_mps),
            follower: PathFollower::new(Arc::new(geometry)),
            speed: path.speed_mps,
            pose,
            parameters: steerwright_models::files::pid_parameters(pid),
            controller: Pid::default(),
            input,
            given: false,
            last_read: (pose, input, false),
            running: None,
        }
    }

    fn guide(&self, [x, y, yaw]: [f64; 3]) -> PathOutput {
        self.follower.evaluate(&self.law, x, y, yaw, self.speed)
    }

    /// Tick 0: a controller that was given no yaw or reference only initialises its memory.
    fn tick_zero(&self, input: &PidInput, given: bool) -> (Pid, PidOutput) {
        let mut controller = self.controller;
        let p = &self.parameters;
        let output = match given {
            true => controller.tick(p, input),
            false => controller.prime(p, input),
        };
        (controller, output)
    }

    fn set(&mut self, unit: usize, signals: &Signals) {
        match unit {
            0 => self.plant.steering_angle = signals.steering.steering_angle,
            1 => self.pose = signals.pose,
            _ => {
                self.input.yaw = signals.pose[2];
                self.input.yaw_reference = signals.path.yaw_reference;
                self.input.steering_feedforward = signals.path.steering_feedforward;
                self.given = true;
            }
        }
    }

    fn read(&mut self, unit: usize, signals: &mut Signals) {
        match (unit, &self.running) {
            (0, _) => {
                signals.pose = [self.plant.x(), self.plant.y(), self.plant.yaw()];
                signals.yaw_rate = self.plant.yaw_rate();
            }
            (1, Some((path, _))) => signals.path = *path,
            (1, None) => {
                self.last_read.0 = self.pose;
                signals.path = self.guide(self.pose);
            }
            (_, Some((_, steering))) => signals.steering = *steering,
            (_, None) => {
                (self.last_read.1, self.last_read.2) = (self.input, self.given);
                signals.steering = self.tick_zero(&self.input, self.given).1;
            }
        }
    }

    /// Leaving initialization mode counts as a read.
    fn leave_initialization(&mut self) {
        self.last_read = (self.pose, self.input, self.given);
    }

    fn step(&mut self, unit: usize, h: f64) {
        if self.running.is_none() {
            let start = self.guide(self.last_read.0);
            self.follower.commit(&start);
            let (controller, output) = self.tick_zero(&self.last_read.1, self.last_read.2);
            self.controller = controller;
            self.running = Some((start, output));
        }
        match unit {
            0 => self.plant.step(h).unwrap(),
            1 => {
                let output = self.guide(self.pose);
                self.follower.commit(&output);
                self.follower.integrate(&self.law, &output, self.speed, h);
                self.running.as_mut().unwrap().0 = output;
            }
            _ => {
                let output = self.controller.tick(&self.parameters, &self.input);
                self.running.as_mut().unwrap().1 = output;
            }
        }
    }
}

/// Time and [`COLUMNS`], a row for each communication point. The step is the controller's sample
/// time, so each has one tick.
pub(crate) fn run(
    plant: &Plant,
    path: &Path,
    pid: &PidFile,
    coupling: LoopCoupling,
    initialization: Initialization,
    steps: usize,
) -> Vec<Vec<f64>> {
    let mut units = Units::new(plant, path, pid);
    let h = pid.sample_time_s;
    // What a connection carries before its output was ever read.
    let mut signals = Signals::default();
    let read_all = |units: &mut Units, signals: &mut Signals| {
        (0..3).for_each(|unit| units.read(unit, signals));
    };
    if initialization == Initialization::Settled {
        read_all(&mut units, &mut signals);
        // No chain of connections is longer than the units are many.
        for unit in [0, 1, 2].repeat(4) {
            units.set(unit, &signals);
            units.read(unit, &mut signals);
        }
    }
    units.leave_initialization();
    if initialization != Initialization::Zeros {
        read_all(&mut units, &mut signals);
    }
    let mut rows = vec![row(0.0, &signals)];
    for k in 0..steps {
        match coupling {
            LoopCoupling::GaussSeidel => {
                for unit in 0..3 {
                    units.set(unit, &signals);
                    units.step(unit, h);
                    units.read(unit, &mut signals);
                }
            }
            LoopCoupling::Jacobi => {
                (0..3).for_each(|unit| units.set(unit, &signals));
                (0..3).for_each(|unit| units.step(unit, h));
                read_all(&mut units, &mut signals);
            }
        }
        rows.push(row((k + 1) as f64 * h, &signals));
    }
    rows
}

fn row(time: f64, s: &Signals) -> Vec<f64> {
    let [x, y, yaw] = s.pose;
    let p = &s.path;
    vec![
        time,
        x,
        y,
        yaw,
        s.yaw_rate,
        p.yaw_reference,
        p.steering_feedforward,
        p.cross_track_error,
        p.heading_error,
        p.curvature,
        p.distance,
        s.steering.steering_angle,
        f64::from(u8::from(s.steering.saturated)),
    ]
}

/// A trajectory as CSV, numbers in the shortest form that reads back exactly.
#[allow(dead_code)]
pub(crate) fn to_csv(rows: &[Vec<f64>]) -> String {
    let mut text = format!("time,{}\n", COLUMNS.join(","));
    for row in rows {
        let cells: Vec<String> = row.iter().map(|value| format!("{value:?}")).collect();
        let _ = writeln!(text, "{}", cells.join(","));
    }
    text
}
