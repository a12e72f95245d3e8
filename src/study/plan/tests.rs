//! Tests of plans: products of sweeps, limits, and messages.

use super::*;

const TEXT: &str = r#"
    scenes = ["cornell"]
    frames = 9
    [[configurations]]
    name = "one"
    preset = "accurate"
    [[sweeps]]
    preset = "accurate"
    [sweeps.over]
    "direct.mis" = ["balance", "pairwise"]
    "direct.spatial.neighbours" = [1, 2, 3]
"#;

#[test]
fn sweeps_are_products() {
    let plan = Plan::parse("plan", TEXT).unwrap();
    let all = plan.resolve().unwrap();
    assert_eq!(all.len(), 7);
    assert_eq!(all[6].name, "pairwise/3");
    assert_eq!(all[6].settings.direct.resampling.spatial.neighbours, 3);
}

#[test]
fn sweeps_without_values_are_refused_before_they_are_multiplied() {
    let many = vec!["1"; 10_000].join(",");
    let over = format!("\"direct.a\" = [{many}]\n\"direct.b\" = [{many}]\n\"direct.c\" = []");
    let text =
        format!("scenes = [\"cornell\"]\n[[sweeps]]\npreset = \"accurate\"\n[sweeps.over]\n{over}");
    let error = Plan::parse("plan", &text).unwrap().resolve().unwrap_err();
    assert!(
        error
            .to_string()
            .contains("direct.c takes a list of values"),
        "{error}"
    );
}

#[test]
fn more_combinations_than_can_be_rendered_are_counted_and_refused() {
    let lists: String = (0..40)
        .map(|key| format!("\"direct.{key}\" = [1, 2, 3, 4]\n"))
        .collect();
    let error = Plan::parse("plan", &format!("{TEXT}{lists}")).unwrap();
    let text = error.resolve().unwrap_err().to_string();
    assert!(text.contains("configurations, and at most 4096"), "{text}");
}

#[test]
fn only_what_resamples_is_claimed_to_be_unbiased_without_a_word() {
    let expected = |more: &str| {
        let text = TEXT.replace("\"one\"\n", &format!("\"one\"\n{more}\n"));
        let all = Plan::parse("plan", &text).unwrap().resolve().unwrap();
        all[0].expect
    };
    assert_eq!(expected(""), Expect::Unbiased);
    assert_eq!(expected("expect = \"any\""), Expect::Any);
    let path_tracing = "set = { integrator = \"path-tracing\" }";
    assert_eq!(expected(path_tracing), Expect::Any);
    let claimed = format!("{path_tracing}\nexpect = \"unbiased\"");
    assert_eq!(expected(&claimed), Expect::Unbiased);
}

#[test]
fn the_programs_own_plans_resolve() {
    for (name, _) in PLANS {
        assert!(
            !Plan::open(name).unwrap().resolve().unwrap().is_empty(),
            "{name}"
        );
    }
    let message = Plan::open("bias-matrx").unwrap_err().to_string();
    assert!(message.contains("bias-matrix"), "{message}");
}

#[test]
fn what_is_wrong_is_named() {
    let parse = |text: &str| {
        let plan = Plan::parse("plan", text)?;
        plan.resolve().map(drop)
    };
    let message = |text: &str| parse(text).unwrap_err().to_string();
    assert!(message(&TEXT.replace("frames = 9", "framez = 9")).contains("framez"));
    assert!(message(&TEXT.replace("frames = 9", "frames = 0")).contains("frames"));
    for (key, value) in [
        ("fps", "0"),
        ("fps", "-24"),
        ("fps", "nan"),
        ("start_time", "inf"),
    ] {
        let text = format!("{key} = {value}\n{TEXT}");
        assert!(message(&text).contains(&format!("plan: {key} ")), "{text}");
    }
    let sums_up = TEXT.replace("\"one\"", "\"one\"\naccumulate = true");
    assert!(parse(&sums_up).is_ok());
    assert!(message(&format!("fps = 24\n{sums_up}")).contains("'one' accumulates"));
    let sums_up = TEXT.replace("[sweeps.over]", "accumulate = true\n[sweeps.over]");
    assert!(message(&format!("fps = 24\n{sums_up}")).contains("'balance/1' accumulates"));
    let indirect = TEXT.replace("direct.mis", "indirect.mis");
    assert!(message(&indirect).contains("indirect.mis"));
    let nested = TEXT.replace("\"one\"", "\"one\"\nset.indirect.mis = \"balance\"");
    assert!(message(&nested).contains("the plan sets indirect,"));
    assert!(parse(&format!("bounces = 2\n{indirect}")).is_ok());
    assert!(message(&TEXT.replace("direct.mis", "direct.mess")).contains("direct.mis"));
    assert!(message(&TEXT.replace("\"accurate\"", "\"acurate\"")).contains("accurate"));
}
