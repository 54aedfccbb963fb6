//! Numbers as text, with the decimals that they need.

/// A number with at most seven digits that count.
pub(crate) fn number(value: f64) -> String {
    tick(value, 1e-6 * value.abs())
}

/// The label of a tick, in whole parts of the power of ten below `step`, which is at most the distance to the next tick.
/// So labels of different ticks differ.
///
/// Very large and very small numbers have an exponent if they are shorter with it.
pub(crate) fn tick(value: f64, step: f64) -> String {
    let power = exponent(step);
    let decimals = |power: i32| usize::try_from(power).unwrap_or(0).min(DIGITS);
    let plain = format!("{value:.*}", decimals(-power));
    let plain = without_zeros(&plain);
    let scientific = format!("{value:.*e}", decimals(exponent(value) - power));
    let (digits, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let scientific = format!("{}e{exponent}", without_zeros(digits));
    let usual = value == 0.0 || (1e-5..1e7).contains(&value.abs());
    let text = if usual || plain.len() <= scientific.len() { plain } else { &scientific };
    match text.strip_prefix('-') {
        Some("0") => "0".to_owned(),
        Some(digits) => format!("−{digits}"),
        None => text.to_owned(),
    }
}

/// Greatest number of decimals, more than a number has that counts.
const DIGITS: usize = 17;

/// Exponent of the power of ten that is at most a number.
fn exponent(value: f64) -> i32 {
    let text = format!("{value:e}");
    text.split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0)
}

/// Cuts zeros at the end off the decimals.
fn without_zeros(digits: &str) -> &str {
    if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { digits }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use plotters::coord::ranged1d::Ranged;
    use plotters::coord::types::RangedCoordf64;

    use super::*;

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (-0.0, "0"),
            (0.1 + 0.2, "0.3"),
            (-1200.0, "−1200"),
            (0.05, "0.05"),
            (1e7, "1e7"),
            (12_345_678.0, "12345678"),
            (2.5e-6, "2.5e-6"),
            (-2.5e12, "−2.5e12"),
        ] {
            assert_eq!(number(value), text);
        }
    }

    #[test]
    fn labels_of_different_ticks_differ() {
        for (from, to) in [
            (12_345_678.0, 12_345_711.0),
            (1.0, 1.000_000_2),
            (-3e-9, 5e-9),
            (1e15, 1e15 + 40.0),
            (-1e300, 1e300),
            (0.0, 1e7),
            (-12.0, 130.0),
        ] {
            for count in [5_u32, 6, 12] {
                let step = (to - from) / f64::from(count);
                let ticks = RangedCoordf64::from(from..to).key_points(count as usize);
                let labels: Vec<String> = ticks.iter().map(|value| tick(*value, step)).collect();
                let different: HashSet<&String> = labels.iter().collect();
                assert!(ticks.len() > 1 && different.len() == ticks.len(), "{labels:?}");
                for (label, value) in labels.iter().zip(&ticks) {
                    let read: f64 = label.replace('−', "-").parse().unwrap();
                    assert!((read - value).abs() < 1e-6 * step, "{label} is not {value}");
                    assert!(label.chars().count() <= 17, "{label}");
                }
            }
        }
    }
}
