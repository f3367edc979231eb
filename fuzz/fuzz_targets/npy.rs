//! Any bytes are an array with as many numbers as its shape says, all of them finite, or an error.
#![no_main]

use libfuzzer_sys::fuzz_target;
use ltsc_core::npy::Array;

fuzz_target!(|bytes: &[u8]| {
    let Ok(array) = Array::open(bytes) else { return };
    assert_eq!(array.shape().iter().product::<usize>(), array.len());
    if let Ok(numbers) = array.numbers() {
        assert!(numbers.len() == array.len() && numbers.iter().all(|number| number.is_finite()));
    }
});
