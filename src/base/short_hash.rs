//! The short form of hashes that is used in file names, lists and messages, where 64 digits would be too long.

/// The first 16 hexadecimal digits (64 bits) of a hash, for file names and messages. Different data
/// practically always have different digits, unless someone constructed them to have equal ones.
pub fn short(hash: &blake3::Hash) -> String {
    hash.to_hex()[..16].to_owned()
}
