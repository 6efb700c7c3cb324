//! CAN databases (DBC): messages and their signals.
//!
//! Read are messages, signals, multiplexing (also extended, `SG_MUL_VAL_`) and floating-point signals
//! (`SIG_VALTYPE_`). Everything else, such as comments, attributes and value tables, changes no number.

use super::bits::{Bits, Order};

/// The messages of a database, and what of it could not be read.
#[derive(Debug, Default)]
pub(super) struct Database {
    pub(super) messages: Vec<Message>,
    pub(super) faults: Vec<String>,
}

#[derive(Debug)]
pub(super) struct Message {
    pub(super) id: u32,
    pub(super) is_extended: bool,
    pub(super) name: String,
    pub(super) signals: Vec<Signal>,
}

#[derive(Debug, Clone)]
pub(super) struct Signal {
    pub(super) name: String,
    pub(super) bits: Bits,
    pub(super) factor: f64,
    pub(super) offset: f64,
    pub(super) unit: String,
    pub(super) is_multiplexer: bool,
    /// The values of other signals with which it is in the message.
    pub(super) conditions: Vec<Condition>,
}

/// A multiplexer, by its place among the signals, and the values that it has.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Condition {
    pub(super) multiplexer: usize,
    pub(super) ranges: Vec<(u64, u64)>,
}

impl Signal {
    /// The physical value: of integers exactly before it is rounded once.
    pub(super) fn value(&self, data: &[u8]) -> Option<f64> {
        let raw = self.bits.raw(data)?;
        let is_whole = |x: f64| x.fract() == 0.0 && x.abs() < 1e15;
        Some(match raw {
            super::bits::Raw::Integer(raw) if is_whole(self.factor) && is_whole(self.offset) => {
                (raw * self.factor as i128 + self.offset as i128) as f64
            }
            super::bits::Raw::Integer(raw) => raw as f64 * self.factor + self.offset,
            super::bits::Raw::Float(raw) => raw * self.factor + self.offset,
        })
    }
}

impl Database {
    /// Reads a database.
    pub(super) fn of_text(file: &str, bytes: &[u8]) -> Self {
        let text = decoded(bytes).replace("\r\n", "\n").replace('\r', "\n");
        let mut database = Self::default();
        let mut in_text = false;
        // Whether signals belong to the last message.
        let mut is_open = false;
        for (k, line) in text.lines().enumerate() {
            let was_in_text = in_text;
            // A quote within a text is written `\"`.
            in_text ^= line.replace("\\\"", "").matches('"').count() % 2 == 1;
            if was_in_text {
                continue;
            }
            let mut words = line.split_whitespace();
            let statement = words.next().unwrap_or_default();
            if !line.contains(' ') || words.next().is_none() {
                continue;
            }
            let rest = line.trim_start().strip_prefix(statement).unwrap_or_default().trim();
            let read = match statement {
                "BO_" => {
                    let place = format!("{file}:{}", k + 1);
                    database.message(rest, &place).map(|taken| is_open = taken)
                }
                "SG_" if is_open => database.signal(rest),
                "SIG_VALTYPE_" => database.value_type(rest),
                "SG_MUL_VAL_" => database.multiplexing(rest),
                _ => Some(()),
            };
            if read.is_none() {
                is_open &= statement != "BO_";
                let shown: String = line.trim().chars().take(80).collect();
                database.faults.push(format!("{file}:{}: not understood: {shown}", k + 1));
            }
        }
        database.resolve(file);
        database
    }

    /// `ID NAME: LENGTH SENDER`; whether it is taken.
    fn message(&mut self, rest: &str, place: &str) -> Option<bool> {
        let (head, _) = rest.split_once(':')?;
        let mut words = head.split_whitespace();
        let (id, name) = (words.next()?.parse::<u64>().ok()?, words.next()?);
        // Signals of no message.
        if id == 0xC000_0000 {
            return Some(false);
        }
        let (id, is_extended) = identifier(u32::try_from(id).ok()?)?;
        let same = |m: &&Message| m.id == id && m.is_extended == is_extended;
        if let Some(first) = self.messages.iter().find(same) {
            self.faults.push(format!(
                "{place}: message {name} has the id {id:#X} of {}, by which the frames are read",
                first.name
            ));
            return Some(false);
        }
        let signals = Vec::new();
        self.messages.push(Message { id, is_extended, name: name.into(), signals });
        Some(true)
    }

    /// `NAME M : START|LENGTH@ORDER SIGN (FACTOR,OFFSET) [LEAST|MOST] "UNIT" RECEIVERS`
    fn signal(&mut self, rest: &str) -> Option<()> {
        let (head, rest) = rest.split_once(':')?;
        let mut words = head.split_whitespace();
        let name = words.next()?;
        let (is_multiplexer, switch) = match words.next() {
            None => (false, None),
            Some("M") => (true, None),
            Some(mark) => {
                let number = mark.strip_prefix('m')?;
                let is_multiplexer = number.ends_with('M');
                (is_multiplexer, Some(number.trim_end_matches('M').parse::<u64>().ok()?))
            }
        };
        let (place, rest) = rest.split_once('(')?;
        let (scale, rest) = rest.split_once(')')?;
        let (start, place) = place.trim().split_once('|')?;
        let (length, kind) = place.split_once('@')?;
        let order = match kind.get(..1)? {
            "1" => Order::Intel,
            "0" => Order::Motorola,
            _ => return None,
        };
        let is_signed = match kind.get(1..)?.trim() {
            "+" => false,
            "-" => true,
            _ => return None,
        };
        let bits =
            Bits::new(start.trim().parse().ok()?, length.trim().parse().ok()?, order, is_signed)?;
        let (factor, offset) = scale.split_once(',')?;
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        let unit = rest.split('"').nth(1).unwrap_or_default();
        // The multiplexer is resolved when all signals of the message are known.
        let condition = |value| Condition { multiplexer: usize::MAX, ranges: vec![(value, value)] };
        self.messages.last_mut()?.signals.push(Signal {
            name: name.into(),
            bits,
            factor: number(factor)?,
            offset: number(offset)?,
            unit: unit.into(),
            is_multiplexer,
            conditions: switch.map(condition).into_iter().collect(),
        });
        Some(())
    }

    fn message_of(&mut self, id: &str) -> Option<&mut Message> {
        let (id, is_extended) = identifier(id.parse().ok()?)?;
        self.messages.iter_mut().find(|m| m.id == id && m.is_extended == is_extended)
    }

    /// `ID SIGNAL : TYPE;`
    fn value_type(&mut self, rest: &str) -> Option<()> {
        let rest = rest.trim_end_matches(';').replace(':', " ");
        let mut words = rest.split_whitespace();
        let (id, name, kind) = (words.next()?, words.next()?, words.next()?);
        let Some(message) = self.message_of(id) else { return Some(()) };
        let signal = message.signals.iter_mut().find(|s| s.name == name)?;
        match kind {
            "0" => Some(()),
            "1" => signal.bits.become_float(32),
            "2" => signal.bits.become_float(64),
            _ => None,
        }
    }

    /// `ID SIGNAL MULTIPLEXER FROM-TO, FROM-TO;`
    fn multiplexing(&mut self, rest: &str) -> Option<()> {
        let mut words = rest.trim_end_matches(';').splitn(4, ' ');
        let (id, name, switch) = (words.next()?, words.next()?, words.next()?);
        let ranges = words.next()?.split(',').map(|range| {
            let (from, to) = range.trim().split_once('-')?;
            Some((from.trim().parse().ok()?, to.trim().parse().ok()?))
        });
        let ranges = ranges.collect::<Option<Vec<(u64, u64)>>>()?;
        let Some(message) = self.message_of(id) else { return Some(()) };
        let multiplexer = message.signals.iter().position(|s| s.name == switch)?;
        let signal = message.signals.iter_mut().find(|s| s.name == name)?;
        signal.conditions = vec![Condition { multiplexer, ranges }];
        Some(())
    }

    /// Finds the multiplexer of each signal, and those that it is multiplexed by in turn.
    fn resolve(&mut self, file: &str) {
        for message in &mut self.messages {
            let root = message
                .signals
                .iter()
                .position(|s| s.is_multiplexer && s.conditions.is_empty())
                .or_else(|| message.signals.iter().position(|s| s.is_multiplexer));
            for k in 0..message.signals.len() {
                for condition in &mut message.signals[k].conditions {
                    if condition.multiplexer == usize::MAX {
                        condition.multiplexer = root.unwrap_or(usize::MAX);
                    }
                }
            }
            let own: Vec<Vec<Condition>> =
                message.signals.iter().map(|s| s.conditions.clone()).collect();
            let (before, name) = (message.signals.len(), message.name.clone());
            for (k, signal) in message.signals.iter_mut().enumerate() {
                let mut at = own[k].first();
                // As deep as there are signals at most, for a circle ends there.
                for _ in 0..own.len() {
                    let Some(parent) = at.and_then(|c| own.get(c.multiplexer)) else { break };
                    at = parent.first();
                    signal.conditions.extend(at.cloned());
                }
            }
            let is_known = |s: &Signal| {
                s.conditions.len() < own.len()
                    && s.conditions.iter().all(|c| c.multiplexer < own.len())
            };
            if message.signals.iter().any(|s| !is_known(s)) {
                message.signals.retain(|s| s.conditions.is_empty());
                let lost = before - message.signals.len();
                self.faults.push(format!(
                    "{file}: message {name}: {lost} multiplexed signals without a multiplexer are not read"
                ));
            }
        }
    }
}

/// The text of a database: UTF-16 by its mark, UTF-8, or else Latin 1, in which `°` is a byte.
fn decoded(bytes: &[u8]) -> String {
    let wide = |of: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|c| of([c[0], c[1]])).collect();
        String::from_utf16_lossy(&units)
    };
    match bytes {
        [0xFF, 0xFE, ..] => wide(u16::from_le_bytes),
        [0xFE, 0xFF, ..] => wide(u16::from_be_bytes),
        _ => std::str::from_utf8(bytes).map_or_else(
            |_| bytes.iter().map(|b| char::from(*b)).collect(),
            |text| text.trim_start_matches('\u{feff}').to_owned(),
        ),
    }
}

/// An identifier without its flag, and whether it has 29 bits: by the flag, or where it needs more than 11.
fn identifier(id: u32) -> Option<(u32, bool)> {
    let bare = id & 0x7FFF_FFFF;
    let is_extended = id != bare || bare > 0x7FF;
    if bare <= 0x1FFF_FFFF { Some((bare, is_extended)) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = r#"VERSION ""
NS_ :
    SG_MUL_VAL_
    SIG_VALTYPE_
BO_ 2147484672 Extended: 8 XXX
 SG_ Mode M : 0|4@1+ (1,0) [0|15] "" XXX
 SG_ Angle m1 : 8|16@1- (0.1,-5) [-100|100] "°" XXX
 SG_ Inner m2M : 8|4@1+ (1,0) [0|0] "" XXX
 SG_ Deep m0 : 16|32@1- (1,0) [0|0] "m/s" XXX
BO_ 36 KINEMATICS: 8 XXX
 SG_ YAW_RATE : 1|10@0+ (1,-512) [0|65535] "" XXX

CM_ "A text
BO_ 99 NOT_A_MESSAGE: 8 XXX
 with \" a quote";
SIG_VALTYPE_ 2147484672 Deep : 1;
SG_MUL_VAL_ 2147484672 Deep Inner 3-4, 7-7;
BO_ 1073741824 TOO_LONG: 8 XXX
 SG_ LOST : 0|8@1+ (1,0) [0|0] "" XXX
BO_ 37 BROKEN: 8 XXX
 SG_ WIDE : 0|65@1+ (1,0) [0|0] "" XXX
"#;

    #[test]
    fn databases_of_other_editors() {
        let text = "BO_ 274923520 A: 8 X\n SG_ S : 0|16@1- (1,0) [0|0] \"°\" X\nBO_ 37 B: 8 X\n";
        let wide = |of: fn(u16) -> [u8; 2]| -> Vec<u8> {
            format!("\u{feff}{text}").encode_utf16().flat_map(of).collect()
        };
        let cr = text.replace('\n', "\r").into_bytes();
        let crlf = text.replace('\n', "\r\n").into_bytes();
        let marked = format!("\u{feff}{text}").into_bytes();
        for bytes in [cr, crlf, marked, wide(u16::to_le_bytes), wide(u16::to_be_bytes)] {
            let database = Database::of_text("a.dbc", &bytes);
            let [a, b] = &database.messages[..] else { panic!("{database:?}") };
            assert_eq!((a.id, a.is_extended, b.is_extended), (0x1063_0000, true, false));
            assert_eq!(a.signals[0].unit, "°");
            assert_eq!(database.faults, Vec::<String>::new());
        }
        let twice = format!("{text}BO_ 37 C: 8 X\n SG_ T : 0|8@1+ (1,0) [0|0] \"\" X\n");
        let database = Database::of_text("a.dbc", twice.as_bytes());
        assert_eq!(database.messages.len(), 2);
        assert_eq!(
            database.faults,
            ["a.dbc:4: message C has the id 0x25 of B, by which the frames are read"]
        );
    }

    #[test]
    fn messages_signals_and_multiplexing() {
        let database = Database::of_text("a.dbc", TEXT.as_bytes());
        let names: Vec<&str> = database.messages.iter().map(|m| m.name.as_str()).collect();
        assert_eq!(names, ["Extended", "KINEMATICS", "BROKEN"]);
        let [extended, ..] = &database.messages[..] else { panic!() };
        assert_eq!((extended.id, extended.is_extended), (1024, true));
        let conditions: Vec<usize> = extended.signals.iter().map(|s| s.conditions.len()).collect();
        assert_eq!(conditions, [0, 1, 1, 2]);
        let deep = &extended.signals[3];
        assert_eq!(deep.conditions[0], Condition { multiplexer: 2, ranges: vec![(3, 4), (7, 7)] });
        assert_eq!(deep.conditions[1], Condition { multiplexer: 0, ranges: vec![(2, 2)] });
        let mut data = vec![2, 3];
        data.extend(2.5_f32.to_le_bytes());
        assert_eq!(deep.value(&data), Some(2.5));
        assert_eq!(extended.signals[1].unit, "°");
        let faults = database.faults.join("\n");
        assert!(faults.contains("a.dbc:18: not understood: BO_ 1073741824 TOO_LONG"), "{faults}");
        assert!(faults.contains("a.dbc:21: not understood: SG_ WIDE"), "{faults}");
        assert_eq!(database.faults.len(), 2);
    }
}
