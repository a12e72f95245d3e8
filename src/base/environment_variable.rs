//! Environment variables that switch functions on.

/// True if a variable is set, and to another value than `0`.
pub fn is_asked_for(variable: &str) -> bool {
    std::env::var_os(variable).is_some_and(|value| value != "0")
}
