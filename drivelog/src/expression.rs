//! Channels combined: `STEER_ANGLE + STEER_FRACTION`, `ANGLE - 2 * ANGLE * SIGN`, `1 - RELEASED`.

/// A product of channels of a group; of none, a constant in the unit of the others.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Term {
    pub(crate) factor: f64,
    pub(crate) channels: Vec<usize>,
}

impl Term {
    /// The sum of the terms at each row; `place` is the place of a channel in `values`.
    pub(crate) fn sum(
        terms: &[Self],
        values: &[Vec<f64>],
        place: impl Fn(usize) -> usize,
    ) -> Vec<f64> {
        let mut all: Vec<f64> = Vec::new();
        let mut constant = 0.0;
        for Self { factor, channels } in terms {
            if channels.is_empty() {
                constant += factor;
                continue;
            }
            let mut product: Option<Vec<f64>> = None;
            for values in channels.iter().map(|c| &values[place(*c)]) {
                match &mut product {
                    Some(product) => product.iter_mut().zip(values).for_each(|(p, x)| *p *= x),
                    None => product = Some(values.clone()),
                }
            }
            let mut product = product.unwrap_or_default();
            if factor.to_bits() != 1.0_f64.to_bits() {
                product.iter_mut().for_each(|x| *x *= factor);
            }
            if all.is_empty() {
                all = product;
            } else {
                all.iter_mut().zip(product).for_each(|(sum, x)| *sum += x);
            }
        }
        if constant.to_bits() != 0.0_f64.to_bits() {
            all.iter_mut().for_each(|sum| *sum += constant);
        }
        all
    }
}

/// The terms of a sum, each with its factor and its names; `None` where the text is a single name.
///
/// Operators have blanks around them, since names may have `+`, `-` and `*` in them.
pub(crate) fn terms(text: &str) -> Option<Vec<(f64, Vec<&str>)>> {
    let (mut sign, mut rest) = match text.strip_prefix('-') {
        Some(rest) => (-1.0, rest.trim_start()),
        None => (1.0, text),
    };
    let mut terms = Vec::new();
    loop {
        let next = [(" + ", 1.0), (" - ", -1.0)].into_iter();
        let next =
            next.filter_map(|(mark, sign)| Some((rest.find(mark)?, sign))).min_by_key(|n| n.0);
        let (mut factor, mut names) = (sign, Vec::new());
        for part in rest[..next.map_or(rest.len(), |n| n.0)].split(" * ").map(str::trim) {
            match part.parse::<f64>() {
                Ok(number) if number.is_finite() => factor *= number,
                _ => names.push(part),
            }
        }
        if names.contains(&"") {
            return None;
        }
        terms.push((factor, names));
        match next {
            Some((at, next)) => (sign, rest) = (next, &rest[at + 3..]),
            None => break,
        }
    }
    let is_single = terms.len() == 1 && text.find(" * ").is_none();
    let has_names = terms.iter().any(|(_, names)| !names.is_empty());
    if !is_single && has_names { Some(terms) } else { None }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_and_products() {
        let of = |text| terms(text);
        assert_eq!(of("A + B"), Some(vec![(1.0, vec!["A"]), (1.0, vec!["B"])]));
        assert_eq!(
            of("-A - 2 * A * SIGN + 0.1 * long name"),
            Some(vec![(-1.0, vec!["A"]), (-2.0, vec!["A", "SIGN"]), (0.1, vec!["long name"])])
        );
        assert_eq!(of("1 - A"), Some(vec![(1.0, vec![]), (-1.0, vec!["A"])]));
        for name in ["A", "-A", "a+b", "a-b*c", "A + ", "3 * 2", "1 - 2", " + A"] {
            assert_eq!(of(name), None, "{name}");
        }
        let values = [vec![1.0, 2.0], vec![0.5, f64::NAN]];
        let sum =
            [Term { factor: 2.0, channels: vec![7] }, Term { factor: -1.0, channels: vec![7, 8] }];
        let sum = Term::sum(&sum, &values, |c| c - 7);
        assert_eq!(sum[0], 1.5);
        assert!(sum[1].is_nan());
        let released =
            [Term { factor: 1.0, channels: vec![] }, Term { factor: -1.0, channels: vec![7] }];
        assert_eq!(Term::sum(&released, &values, |c| c - 7), [0.0, -1.0]);
    }
}
