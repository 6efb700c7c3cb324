//! Parameters as the numbers of a saved state.
//!
//! A document leaves out some numbers that are 0. The bytes of a state have no names, so a state has all of them.

/// Serializes parameters, all of them `f64`, as the numbers at these places, one after the other.
macro_rules! as_numbers {
    ($name:ident: $($($field:ident).+)+) => {
        impl $name {
            const NUMBERS: usize = [$(stringify!($($field).+)),+].len();

            /// All parameters.
            pub(crate) fn numbers(&self) -> [f64; Self::NUMBERS] {
                [$(self.$($field).+),+]
            }
        }

        // Every number of the parameters has its place.
        const _: () = assert!(size_of::<$name>() == $name::NUMBERS * size_of::<f64>());

        impl serde::Serialize for $name {
            fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serde::Serialize::serialize(&self.numbers(), serializer)
            }
        }

        impl<'de> serde::Deserialize<'de> for $name {
            fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let numbers: [f64; Self::NUMBERS] = serde::Deserialize::deserialize(deserializer)?;
                let mut read = Self::default();
                let places = [$(&mut read.$($field).+),+];
                for (place, number) in places.into_iter().zip(numbers) {
                    *place = number;
                }
                Ok(read)
            }
        }
    };
}

pub(crate) use as_numbers;
