//! The benchmark's table, and the aims that it is held against.

/// Smallest, middle and largest of some rounds.
#[derive(Clone, Copy)]
pub(crate) struct Statistics {
    min: f64,
    median: f64,
    max: f64,
}

impl Statistics {
    pub(crate) fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        Self { min: values[0], median: values[values.len() / 2], max: values[values.len() - 1] }
    }
}

/// The subject, and the nanoseconds of a call.
pub(crate) struct Row {
    pub(crate) name: String,
    pub(crate) ns: Statistics,
}

/// At most so many nanoseconds for what is timed, beyond what another costs.
struct Aim {
    what: &'static str,
    timed: &'static str,
    beyond: Option<&'static str>,
    most_ns: f64,
}

const AIMS: [Aim; 7] = [
    Aim {
        what: "the layer, every check on, over the bare library",
        timed: "Linear step",
        beyond: Some("bare linear_step"),
        most_ns: 5.0,
    },
    Aim {
        what: "four linear states without position",
        timed: "Linear step",
        beyond: None,
        most_ns: 12.0,
    },
    Aim {
        what: "IdentifiedPlant, with position",
        timed: "IdentifiedPlant step",
        beyond: None,
        most_ns: 60.0,
    },
    Aim {
        what: "IdentifiedPlant without continuous form, with position",
        timed: "IdentifiedPlant (no continuous form) step",
        beyond: None,
        most_ns: 60.0,
    },
    Aim {
        what: "BicyclePlant, a new speed at every step",
        timed: "BicyclePlant setstep",
        beyond: None,
        most_ns: 300.0,
    },
    Aim { what: "LateralPid", timed: "LateralPid step", beyond: None, most_ns: 25.0 },
    Aim {
        what: "an FMU that does nothing, which has no aim of its own",
        timed: "Empty step",
        beyond: None,
        most_ns: f64::INFINITY,
    },
];

/// How many times faster than pythonfmu each aim's subject has to be.
const TIMES_FASTER: f64 = 100.0;

/// Prints the time of every call, then the design targets.
pub(crate) fn print(rows: &[Row], rounds: usize) {
    println!("nanoseconds a call, of {rounds} rounds");
    println!("{:<46}{:>10}{:>10}{:>10}", "", "least", "median", "most");
    for Row { name, ns } in rows {
        println!("{name:<46}{:>10.1}{:>10.1}{:>10.1}", ns.min, ns.median, ns.max);
    }
    let find = |name: &str| rows.iter().find(|row| row.name == name).map(|row| row.ns);
    let verdict = |met| if met { "met" } else { "NOT MET" };
    println!("\n{:<62}{:>8}{:>8}{:>8}", "aims, by the medians", "aim", "ns", "least");
    for aim in &AIMS {
        let beyond = match aim.beyond {
            Some(name) => find(name),
            None => Some(Statistics { min: 0.0, median: 0.0, max: 0.0 }),
        };
        let (Some(timed), Some(beyond)) = (find(aim.timed), beyond) else {
            println!("{:<62}{:>8}", aim.what, "not timed");
            continue;
        };
        let (median, least) = (timed.median - beyond.median, timed.min - beyond.min);
        let (most, met) = if aim.most_ns.is_finite() {
            (aim.most_ns.to_string(), verdict(median <= aim.most_ns))
        } else {
            (String::new(), "")
        };
        println!("{:<62}{most:>8}{median:>8.1}{least:>8.1}  {met}", aim.what);
    }
    // Like with like: a step with a step, and a step with a new input with another one.
    let (Some(step), Some(setstep)) = (find("pythonfmu step"), find("pythonfmu setstep")) else {
        println!("\nleft out: pythonfmu (STEERWRIGHT_BENCH_PYTHONFMU is not set)");
        return;
    };
    println!("\n{:<62}{:>8}{:>8}", "times faster than pythonfmu's linear model", "aim", "times");
    for aim in AIMS.iter().filter(|aim| aim.beyond.is_none()) {
        let Some(timed) = find(aim.timed) else { continue };
        let python = if aim.timed.ends_with("setstep") { setstep } else { step };
        let times = python.median / timed.median;
        let met = verdict(times >= TIMES_FASTER);
        println!("{:<62}{TIMES_FASTER:>8}{times:>8.0}  {met}", aim.what);
    }
}
