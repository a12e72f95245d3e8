//! Results of regression tests as JUnit XML, a format that CI systems read and show.

use super::verdict::Verdict;
use crate::base::printable::printable;
use crate::{Error, Result};
use quick_junit::{NonSuccessKind, Report, TestCase, TestCaseStatus, TestSuite};
use std::time::Duration;

/// The report of a run as JUnit XML text. `driver` is the name of the tested driver. `results` has the name,
/// the verdict and the duration of each case that has finished. `running` is the name of the case that runs
/// now, or `None` at the end. The report lists this case as an error: if the driver crashes and ends the
/// program, the report that was written last shows the case.
///
/// # Errors
/// The XML library cannot write the text, which does not happen with the names in `cases.toml`.
pub fn report(
    driver: &str,
    results: &[(String, Verdict, Duration)],
    running: Option<&str>,
) -> Result<String> {
    let mut suite = TestSuite::new(format!("headwater regress on {}", printable(driver)));
    for (name, verdict, time) in results {
        let status = match verdict {
            Verdict::Passed(_) => TestCaseStatus::success(),
            Verdict::Skipped(why) => with_message(TestCaseStatus::skipped(), why),
            Verdict::Failed(why) => {
                with_message(TestCaseStatus::non_success(NonSuccessKind::Failure), why)
            }
        };
        let mut case = named(name, status);
        case.set_time(*time);
        suite.add_test_case(case);
    }
    if let Some(name) = running {
        let status = TestCaseStatus::non_success(NonSuccessKind::Error);
        let status = with_message(status, "the program ended while this case ran");
        suite.add_test_case(named(name, status));
    }
    let mut report = Report::new("headwater");
    report.add_test_suite(suite);
    report
        .to_string()
        .map_err(|e| Error::failed(format!("the JUnit report: {e}")))
}

fn named(name: &str, status: TestCaseStatus) -> TestCase {
    let mut case = TestCase::new(name, status);
    case.set_classname("headwater.regress");
    case
}

fn with_message(mut status: TestCaseStatus, message: &str) -> TestCaseStatus {
    status.set_message(printable(message));
    status
}
