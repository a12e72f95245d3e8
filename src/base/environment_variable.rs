//! Reads the environment variables, such as `HEADWATER_VALIDATION`, with which the user switches on a feature of the
//! program.

/// True if the user switches on a feature with the environment variable `variable`: it is set to a value other than `0`.
/// An empty value counts as set.
pub fn is_asked_for(variable: &str) -> bool {
    std::env::var_os(variable).is_some_and(|value| value != "0")
}
