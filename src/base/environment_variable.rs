//! Environment variables that switch a function on or off.

/// True if the environment variable with this name is set to a value other than `0`; an empty value counts as set.
pub fn is_asked_for(variable: &str) -> bool {
    std::env::var_os(variable).is_some_and(|value| value != "0")
}
