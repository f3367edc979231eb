//! Numbers as text, in the shortest form that reads back as the same number.

use std::fmt;

/// A finite number in the shortest decimal form that reads back as the same `f64`.
///
/// The form is one that Mitsuba (`strtod` and its successors), PBRT v3 and v4, LuxCore and JSON all read: digits, at
/// most one point with digits on both sides, and an exponent only where the plain form would grow long. `-0` is
/// written as `0`, because no target distinguishes the two and text comparisons should not either.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Num(pub f64);

impl fmt::Display for Num {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let size = self.0.abs();
        if size == 0.0 {
            f.write_str("0")
        } else if (1e-5..1e16).contains(&size) {
            write!(f, "{}", self.0)
        } else {
            write!(f, "{:e}", self.0)
        }
    }
}

/// Numbers with a separator between them.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a>(pub &'a [f64], pub &'static str);

impl fmt::Display for Row<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, value) in self.0.iter().enumerate() {
            if at > 0 {
                f.write_str(self.1)?;
            }
            Num(*value).fmt(f)?;
        }
        Ok(())
    }
}

/// A count as the signed 32-bit integer that every text target reads; larger ones become the largest.
pub fn count(value: u32) -> u32 {
    value.min(i32::MAX as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn numbers_are_short() {
        let text = |x: f64| Num(x).to_string();
        assert_eq!(text(0.1), "0.1");
        assert_eq!(text(-0.0), "0");
        assert_eq!(text(512.0), "512");
        assert_eq!(text(-2.5e-9), "-2.5e-9");
        assert_eq!(text(1e300), "1e300");
        assert_eq!(text(f64::from(0.1_f32)), "0.10000000149011612");
        assert_eq!(Row(&[1.0, 0.5, -3.0], ", ").to_string(), "1, 0.5, -3");
        assert_eq!((count(7), count(u32::MAX)), (7, 2_147_483_647));
    }

    proptest! {
        #[test]
        fn numbers_read_back(bits: u64) {
            let value = f64::from_bits(bits);
            prop_assume!(value.is_finite());
            let text = Num(value).to_string();
            prop_assert_eq!(text.parse::<f64>().expect("a number"), value);
            prop_assert!(text.len() <= 25, "{}", text);
            // The grammar of JSON, which is the narrowest of all targets.
            let json: f64 = serde_json::from_str(&text).expect("a JSON number");
            prop_assert!((json - value).abs() <= value.abs() * 1e-15);
        }
    }
}
