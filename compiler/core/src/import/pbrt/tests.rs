//! Cases of each construct, worked out by hand.
