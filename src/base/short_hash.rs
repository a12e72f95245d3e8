//! The short form of hashes for file names, lists and messages.

/// The first 16 hexadecimal digits of a hash. Their 64 bits distinguish data that were not constructed to collide.
pub fn short(hash: &blake3::Hash) -> String {
    hash.to_hex()[..16].to_owned()
}
