//! The short form of hashes that is used in file names, lists and messages, where 64 digits would be too long.

/// The first 16 hexadecimal digits (64 bits) of a hash. They distinguish all data except those that someone constructed
/// to have equal digits.
pub fn short(hash: &blake3::Hash) -> String {
    hash.to_hex()[..16].to_owned()
}
