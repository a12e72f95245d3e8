//! Hashes as they stand in file names, lists and messages.

/// The first 16 of a hash's hexadecimal digits: 64 bits tell things apart that nobody has made to be alike.
pub fn short(hash: &blake3::Hash) -> String {
    hash.to_hex()[..16].to_owned()
}
