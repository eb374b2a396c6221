//! Refusals in words: field, reason, the number that was given and what it may be.

use crate::ground::error::{Code, Error};
use crate::ground::math;
use crate::scene::fields::{Field, Range, field};
use core::fmt::Write;

/// Text of an error: at most 160 bytes, no allocation.
pub type Text = heapless::String<160>;

impl Error {
    /// Sentence for a log: `time_step.seconds: time step too large; the largest allowed is 2.6449e-8 s`,
    /// `sheet.plies: out of range; it is 0, must be at least 1 and at most 1000`,
    /// `image: buffer too short: it has 0 bytes, needed are 28216`,
    /// `back.plies: out of range; it is 2: see stack.plies`,
    /// `slack_balance: does not go with another field: integrator.kind`.
    pub fn text(&self) -> Text {
        self.text_within(field(self.field).map(Field::limits))
    }

    /// Sentence of a field whose least and greatest value are these.
    pub fn text_within(&self, limits: Option<[f64; 2]>) -> Text {
        let of_another_length = self.code == Code::ImageMalformed && self.limit != 0.0;
        let reason = if of_another_length { "snapshot image of another length" } else { self.code.words() };
        let mut text = Text::new();
        // A text that does not fit is cut; the code and the field come first.
        say(&mut text, &[self.field, if self.field.is_empty() { "" } else { ": " }, reason]);
        match self.code {
            Code::StepTooLarge => quantity(&mut text, "; the largest allowed is ", self.limit, "s"),
            Code::ProjectileTooFast => quantity(&mut text, "; the largest step for this motion is ", self.limit, "s"),
            Code::NotFinite | Code::NotPositive | Code::OutOfRange => {
                let row = field(self.field);
                let unit = row.and_then(|row| row.quantity).map_or("1", |quantity| quantity.unit);
                quantity(&mut text, "; it is ", self.value, unit);
                let [least, greatest] = limits.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
                let crossed = self.code == Code::OutOfRange && !(least..=greatest).contains(&self.value);
                let (lower, upper) = match row.map(|row| row.range) {
                    Some(Range::Above(end, _)) => (("greater than ", end), ("at most ", greatest)),
                    Some(Range::Below(_, end)) => (("at least ", least), ("less than ", end)),
                    _ => (("at least ", least), ("at most ", greatest)),
                };
                let mut before = ", must be ";
                for (words, end) in [lower, upper].into_iter().filter(|(_, end)| crossed && end.is_finite()) {
                    say(&mut text, &[before]);
                    quantity(&mut text, words, end, unit);
                    before = " and ";
                }
            }
            _ => {}
        }
        match self.code {
            _ if self.with.is_empty() => {}
            Code::NotBuilt => {
                say(&mut text, &[" `", self.with, "`, which this build lacks: fabric-kernel = { ..., features = [\""]);
                say(&mut text, &[self.with, "\"] } in Cargo.toml"]);
            }
            Code::DoesNotGoWith => say(&mut text, &[": ", self.with]),
            _ => say(&mut text, &[": see ", self.with]),
        }
        if of_another_length || self.code == Code::ShortBuffer && self.limit != 0.0 {
            say(&mut text, &[": it has "]);
            whole(&mut text, self.value as u64);
            say(&mut text, &[" bytes, needed are "]);
            whole(&mut text, self.limit as u64);
        }
        text
    }
}

#[inline(never)]
fn say(text: &mut Text, parts: &[&str]) {
    parts.iter().for_each(|part| _ = text.push_str(part));
}

#[inline(never)]
fn quantity(text: &mut Text, before: &str, value: f64, unit: &str) {
    say(text, &[before, &number(value)]);
    if value.is_finite() && unit != "1" {
        say(text, &[" ", unit]);
    }
}

/// A number as a text: whole ones below 1e6 as they are, others with five digits, rounded towards zero (to
/// 1e-12) so that a limit may be used as it stands.
/// The library's formatting of a float would need panics and 20 KB of code.
pub fn number(value: f64) -> Text {
    let mut text = Text::new();
    if !value.is_finite() {
        say(&mut text, &[if value.is_nan() { "not a number" } else { "infinite" }]);
        return text;
    }
    if (0.0..1e6).contains(&value) && value as u64 as f64 == value {
        whole(&mut text, value as u64);
        return text;
    }
    let (mut size, mut exponent) = (math::abs(value), 0_i32);
    while size >= 10.0 {
        (size, exponent) = (size / 10.0, exponent + 1);
    }
    while size < 1.0 {
        (size, exponent) = (size * 10.0, exponent - 1);
    }
    // What the divisions may have rounded up or down is less than this: a whole number of digits stays one.
    let digits = (size * 1e4 + 1e-8) as u64;
    say(&mut text, &[if value < 0.0 { "-" } else { "" }]);
    whole(&mut text, digits / 10_000);
    let mut rest = digits % 10_000;
    say(&mut text, &[if rest > 0 { "." } else { "" }]);
    // Digit by digit: a width would take the formatter's padding, which calls through pointers.
    while rest > 0 {
        whole(&mut text, rest / 1000);
        rest = rest % 1000 * 10;
    }
    if exponent != 0 {
        say(&mut text, &[if exponent < 0 { "e-" } else { "e" }]);
        whole(&mut text, exponent.unsigned_abs().into());
    }
    text
}

#[inline(never)]
fn whole(text: &mut Text, number: u64) {
    _ = write!(text, "{number}");
}

impl core::fmt::Display for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.text())
    }
}

impl core::fmt::Debug for Error {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(&self.text())
    }
}

impl core::error::Error for Error {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_of_a_number_has_its_unit_and_the_ends_that_it_may_have() {
        for (code, field, value, limit, text) in [
            (Code::OutOfRange, "sheet.plies", 0.0, 1.0, "out of range; it is 0, must be at least 1 and at most 1000"),
            (Code::OutOfRange, "sheet.radius", -0.5, 0.0, "out of range; it is -5e-1 m, must be at least 0 m"),
            (
                Code::OutOfRange,
                "yarn.alpha_fail",
                1.0,
                1.0,
                "out of range; it is 1, must be at least 0 and less than 1",
            ),
            (Code::OutOfRange, "yarn.damage_b", 2.0, 1.0, "out of range; it is 2, must be less than 1"),
            (
                Code::OutOfRange,
                "back.critical_stretch",
                1.0,
                1.0,
                "out of range; it is 1, must be greater than 1 and at most 2",
            ),
            (Code::OutOfRange, "sheet.radius", 9.0, 1.0, "out of range; it is 9 m"),
            (Code::NotPositive, "sheet.spacing", -1.0, 0.0, "must be greater than zero; it is -1 m"),
            (Code::NotFinite, "sheet.spacing", f64::NAN, 0.0, "not a finite number; it is not a number"),
        ] {
            assert_eq!(Error::new(code, field, value, limit).text().as_str(), std::format!("{field}: {text}"));
        }
        let own = Error::new(Code::OutOfRange, "ply.first", 9.0, 0.0).text_within(Some([f64::NEG_INFINITY, 7.0]));
        assert_eq!(own.as_str(), "ply.first: out of range; it is 9, must be at most 7");
    }

    #[test]
    fn step_text_names_the_largest_step() {
        let error = Error::new(Code::StepTooLarge, "dt", 3e-8, 2.6449971e-8);
        assert_eq!(error.text().as_str(), "dt: time step too large; the largest allowed is 2.6449e-8 s");
        let error = Error::new(Code::ProjectileTooFast, "projectile.velocity", 400.0, 1.8142857e-6);
        let text = "projectile.velocity: projectile crosses more than a node spacing in a step; \
                    the largest step for this motion is 1.8142e-6 s";
        assert_eq!(error.text().as_str(), text);
    }

    #[test]
    fn text_of_a_length_names_both_and_debug_is_the_text() {
        let error = Error::new(Code::ShortBuffer, "memory", 64.0, 58_545_408.0);
        assert_eq!(std::format!("{error:?}"), "memory: buffer too short: it has 64 bytes, needed are 58545408");
        let cut = Error::new(Code::ImageMalformed, "image", 8.0, 28_216.0);
        assert_eq!(cut.text().as_str(), "image: snapshot image of another length: it has 8 bytes, needed are 28216");
        assert_eq!(
            Error::plain(Code::ImageMalformed, "image").text().as_str(),
            "image: no snapshot image, or an altered one"
        );
    }

    #[test]
    fn numbers_have_five_digits_and_are_rounded_towards_zero() {
        for (value, expected) in [
            (0.0, "0"),
            (1e-17, "1e-17"),
            (2.99999e-8, "2.9999e-8"),
            (1.0, "1"),
            (-0.05, "-5e-2"),
            (12.345678, "1.2345e1"),
            (1e6, "1e6"),
            (65_536.0, "65536"),
            (1.0305e-300, "1.0305e-300"),
            (f64::NAN, "not a number"),
            (f64::NEG_INFINITY, "infinite"),
            (f64::MAX, "1.7976e308"),
            (5e-324, "4.9406e-324"),
        ] {
            assert_eq!(number(value).as_str(), expected);
        }
    }
}
