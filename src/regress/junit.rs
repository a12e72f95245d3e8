//! JUnit XML, as the pages of CI systems show it.

use super::verdict::Verdict;
use crate::{Error, Result};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::time::Duration;

/// The report of cases, each with what it took.
///
/// # Errors
/// Never with names that XML can hold.
pub fn report(driver: &str, results: &[(String, Verdict, Duration)]) -> Result<String> {
    let mut suite = TestSuite::new(format!("headwater regress on {driver}"));
    for (name, verdict, time) in results {
        let status = match verdict {
            Verdict::Passed(_) => TestCaseStatus::success(),
            Verdict::Skipped(why) => {
                let mut status = TestCaseStatus::skipped();
                status.set_message(why.as_str());
                status
            }
            Verdict::Failed(why) => {
                let mut status = TestCaseStatus::non_success(NonSuccessKind::Failure);
                status.set_message(why.as_str());
                status
            }
        };
        let mut case = TestCase::new(name.as_str(), status);
        case.set_classname("headwater.regress").set_time(*time);
        suite.add_test_case(case);
    }
    let mut report = Report::new("headwater");
    report.add_test_suite(suite);
    report
        .to_string()
        .map_err(|e| Error::failed(format!("the JUnit report: {e}")))
}
