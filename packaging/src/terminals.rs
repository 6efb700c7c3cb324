//! `terminalsAndIcons/terminalsAndIcons.xml`: which variables belong together in a connection, and
//! where the icon and its terminals are drawn.
//!
//! FMI 2.0.4 took the file over from FMI 3.0 (section 2.4.9 there), so `fmiVersion` names the version whose
//! schema it follows. FMUs whose terminals share a name are meant for each other; members match by their
//! names (`plug`: all of them, `bus`: those there are).

use model_description::{Causality, ModelDescription};
use quick_xml::escape::escape;
use std::fmt::Write;

/// A named group of variables in every FMU that has some of them.
struct Terminal {
    name: &'static str,
    matching: &'static str,
    description: &'static str,
    members: &'static [&'static str],
}

/// The reverse domain name of the project's own kinds and folders.
pub(crate) const DOMAIN: &str = "io.github.steerwright";

const TERMINALS: &[Terminal] = &[
    Terminal {
        name: "pose",
        matching: "bus",
        description: "position and yaw of the vehicle",
        members: &["x", "y", "yaw"],
    },
    Terminal {
        name: "sideslip",
        matching: "plug",
        description: "what was learnt of the vehicle's sideslip",
        members: &["sideslip_per_yaw_rate_offset"],
    },
    Terminal {
        name: "guidance",
        matching: "plug",
        description: "yaw reference, and the steering angle for the road's curvature",
        members: &["yaw_reference", "steering_feedforward"],
    },
    Terminal {
        name: "steering",
        matching: "plug",
        description: "steering angle",
        members: &["steering_angle"],
    },
    Terminal {
        name: "pedals",
        matching: "bus",
        description: "accelerator and brake, or acceleration command",
        members: &["accelerator", "brake", "acceleration_command"],
    },
];

/// The icon's half width, and a terminal's, in units of the coordinate system (0.1 mm).
const HALF: f64 = 100.0;
const TERMINAL_HALF: f64 = 10.0;

pub(crate) fn xml(description: &ModelDescription) -> String {
    let mut text = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiTerminalsAndIcons fmiVersion=\"3.0\">\n  \
         <GraphicalRepresentation>\n    <CoordinateSystem x1=\"-100\" y1=\"-100\" x2=\"100\" \
         y2=\"100\" suggestedScalingFactorTo_mm=\"0.1\"/>\n    <Icon x1=\"-100\" y1=\"-100\" \
         x2=\"100\" y2=\"100\"/>\n  </GraphicalRepresentation>\n",
    );
    let present: Vec<_> = TERMINALS
        .iter()
        .filter_map(|terminal| {
            let inputs = members(description, terminal, Causality::Input);
            let outputs = members(description, terminal, Causality::Output);
            if inputs.len() >= outputs.len() {
                if inputs.is_empty() { None } else { Some((terminal, Causality::Input, inputs)) }
            } else {
                Some((terminal, Causality::Output, outputs))
            }
        })
        .collect();
    if !present.is_empty() {
        text.push_str("  <Terminals>\n");
        for (terminal, causality, members) in &present {
            let side: Vec<_> = present.iter().filter(|(_, c, _)| c == causality).collect();
            let place = side.iter().position(|(t, _, _)| t.name == terminal.name).unwrap_or(0);
            element(&mut text, terminal, members, *causality, place, side.len());
        }
        text.push_str("  </Terminals>\n");
    }
    text.push_str("</fmiTerminalsAndIcons>\n");
    text
}

fn members(
    description: &ModelDescription,
    terminal: &Terminal,
    causality: Causality,
) -> Vec<&'static str> {
    let has = |name: &&&str| {
        description.variable(name).is_some_and(|variable| variable.causality == causality)
    };
    terminal.members.iter().filter(has).copied().collect()
}

/// Inputs are drawn at the left edge and outputs at the right, spread over its height.
fn element(
    text: &mut String,
    terminal: &Terminal,
    members: &[&str],
    causality: Causality,
    place: usize,
    count: usize,
) {
    let Terminal { name, matching, description, .. } = terminal;
    let _ = writeln!(
        text,
        "    <Terminal name=\"{name}\" matchingRule=\"{matching}\" terminalKind=\"{DOMAIN}.{name}\" \
         description=\"{}\">",
        escape(*description)
    );
    for member in members {
        let member = escape(*member);
        let _ = writeln!(
            text,
            "      <TerminalMemberVariable variableName=\"{member}\" memberName=\"{member}\" \
             variableKind=\"signal\"/>"
        );
    }
    let x = if causality == Causality::Input { -HALF } else { HALF };
    #[allow(clippy::cast_precision_loss)] // a handful
    let y = HALF - 2.0 * HALF * (place as f64 + 0.5) / count as f64;
    let h = TERMINAL_HALF;
    let _ = writeln!(
        text,
        "      <TerminalGraphicalRepresentation defaultConnectionColor=\"31 78 121\" \
         defaultConnectionStrokeSize=\"2\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" \
         iconBaseName=\"terminal\"/>\n    </Terminal>",
        x - h,
        y - h,
        x + h,
        y + h
    );
}
