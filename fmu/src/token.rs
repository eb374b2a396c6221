//! The token: a library and a model description of different builds refuse each other.

use crate::parameters::Parameters;
use crate::table::{Kind, MOST_ELEMENTS, VARIABLES};

/// A hash of the model's name, of the table (names, references, types, roles, sizes), of the start values and
/// of the kernel's version and image format; as many bits as a token shows.
pub fn hash(mut starts: Parameters) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325;
    let mut take =
        |bytes: &[u8]| bytes.iter().for_each(|byte| hash = (hash ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3));
    take(crate::MODEL_IDENTIFIER.as_bytes());
    take(fabric_kernel::VERSION.as_bytes());
    take(&fabric_kernel::FORMAT.to_le_bytes());
    for variable in &VARIABLES {
        take(variable.name.as_bytes());
        take(&variable.reference.to_le_bytes());
        if let Some(quantity) = variable.quantity {
            take(quantity.name.as_bytes());
            take(quantity.unit.as_bytes());
        }
        let kind = match variable.kind {
            Kind::Real => 0,
            Kind::Integer => 1,
            Kind::Boolean => 2,
            Kind::Choice(_) => 3,
        };
        take(&[kind, variable.role as u8, variable.size() as u8]);
        if !variable.role.is_output() {
            let mut values = [0.0; MOST_ELEMENTS];
            starts.get(variable, &mut values);
            values.iter().take(variable.size()).for_each(|start| take(&start.to_bits().to_le_bytes()));
        }
    }
    hash & ((1 << 52) - 1)
}

/// The token as a text: guid of FMI 2.0, instantiationToken of FMI 3.0.
pub fn text(number: u64) -> [u8; 28] {
    let (mut token, mut rest) = (*b"{FabricShield-0000000000000}", number);
    for place in token.iter_mut().skip(14).take(13).rev() {
        let digit = (rest & 15) as u8;
        *place = if digit < 10 { b'0' + digit } else { b'a' + digit - 10 };
        rest >>= 4;
    }
    token
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::starts::Starts;

    #[test]
    fn it_is_readable() {
        let (hash, text) = (Starts::own().token, text(Starts::own().token));
        assert!(std::format!("{hash:013x}") == core::str::from_utf8(&text[14..27]).unwrap());
        assert!(core::str::from_utf8(&text).unwrap().starts_with("{FabricShield-"));
    }
}
