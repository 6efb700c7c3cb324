//! Near matches for misspelt names.

use strsim::osa_distance;

/// The names that a misspelt one may have meant, the nearest first, at most five.
#[must_use]
pub fn near<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Vec<String> {
    let wanted = name.to_lowercase();
    let mut found: Vec<(usize, &str)> = known
        .into_iter()
        .filter_map(|candidate| {
            let lower = candidate.to_lowercase();
            let distance = osa_distance(&wanted, &lower);
            let allowed = (wanted.chars().count() / 3).max(1);
            let contained = wanted.len().min(lower.len()) >= 3
                && (lower.contains(&wanted) || wanted.contains(&lower));
            // A name inside the other counts as far as a typing error can be.
            if distance <= allowed {
                Some((distance, candidate))
            } else {
                if contained { Some((allowed + 1, candidate)) } else { None }
            }
        })
        .collect();
    found.sort();
    found.into_iter().take(5).map(|(_, candidate)| candidate.to_owned()).collect()
}

/// Near names as the end of a message; nothing where there are none.
pub(crate) fn near_text(near: &[String]) -> String {
    if near.is_empty() { String::new() } else { format!("; near it: {}", near.join(", ")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typing_errors_and_parts_of_names_are_found_nearest_first() {
        let known = ["yaw", "yaw_rate", "steering_angle", "x", "y"];
        assert_eq!(near("yaw_rat", known), ["yaw_rate", "yaw"]);
        assert_eq!(near("steering", known), ["steering_angle"]);
        assert_eq!(near("Yaw", known), ["yaw", "yaw_rate"]);
        assert!(near("mass", known).is_empty());
    }
}
