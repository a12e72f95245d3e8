"""Clicks through a page in a headless Chromium, as a user would, and checks the effects:

    tests/page/browse clicks.py PAGE.html [FOLDER]

With FOLDER, it also writes a picture of each section there, in both colour schemes and at two widths.
"""

import os
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

PAGE = Path(sys.argv[1]).resolve()
FOLDER = Path(sys.argv[2]) if len(sys.argv) > 2 else None
# The colour of the page, as a script.
BACK = "getComputedStyle(document.body).backgroundColor"
WIDTHS = {"wide": 1280, "narrow": 360}


def check(holds, what):
    if not holds:
        raise SystemExit(f"clicks.py: {what}")


class User:
    """A browser window with the page in it, which records errors and requests."""

    def __init__(self, browser, width, scheme="light"):
        self.page = browser.new_page(viewport={"width": width, "height": 800}, color_scheme=scheme)
        self.troubles = []
        self.page.on("console", lambda message: self.troubles.append(message.text))
        self.page.on("pageerror", lambda error: self.troubles.append(str(error)))
        self.page.on("request", self.requested)
        self.page.goto(PAGE.as_uri())
        self.page.wait_for_selector("#scatter svg")

    def requested(self, request):
        if request.url != PAGE.as_uri() and not request.url.startswith("data:"):
            self.troubles.append(f"request of {request.url}")

    def text(self, selector):
        return self.page.inner_text(selector)

    def picture(self):
        """The pixels of the comparison, as one text."""
        return self.page.eval_on_selector("#canvas", "canvas => canvas.toDataURL()")

    def changes(self, what, action):
        """Checks that an action changes the comparison."""
        before = self.picture()
        action()
        check(self.picture() != before, f"{what} does not change the comparison")

    def slide(self, selector, value):
        self.page.eval_on_selector(
            selector, "(e, value) => { e.value = value; e.dispatchEvent(new Event('input', { bubbles: true })); }", value
        )

    def close(self):
        check(not self.troubles, f"the page reports: {self.troubles}")
        self.page.close()


def answer_comes_first(user):
    box = user.page.locator("#answer").bounding_box()
    check(box["y"] + box["height"] <= 800, "the answer is not on the first screen")
    check(user.page.title().startswith("Which preset"), "text of the scene was executed")
    check("balanced" in user.text("#answer h1") and "headwater render" in user.text("#command"), "the answer is not complete")


def points_are_chosen(user):
    page = user.page
    for index, name in enumerate(["balanced", "path-tracing", "accurate", "fast"]):
        page.click(f"#scatter [data-point='{index}'] .bubble-text")
        check(name in user.text("#chosen-title"), f"a click does not choose {name}")
        check(f"--preset {name} " in user.text("#chosen-command"), f"the command of {name} is not shown")
        check(page.get_attribute(f"#scatter [data-point='{index}']", "aria-checked") == "true", "the point is not marked")
        check("95 % interval" in user.text("#chosen-numbers"), "the interval is not shown")
        shown = page.locator("#thumbs canvas").count()
        check(shown == (0 if name == "fast" else 4), f"{name} has {shown} small pictures")
    page.click("#points tr[data-point='2'] button")
    check("accurate" in user.text("#chosen-title"), "a click on a row does not choose its point")
    page.focus("#scatter [data-point='2']")
    page.keyboard.press("ArrowLeft")
    check("eighth" in user.text("#chosen-title"), "an arrow key does not choose the next faster point")
    page.click("#chosen summary")
    check("# eighth" in user.text("#chosen-settings"), "the settings are not shown")
    page.click("#noise tr[data-point='0'] button")
    check("balanced" in user.text("#chosen-title"), "a click on a row of the second table does not choose its point")


def pictures_are_compared(user):
    page = user.page
    page.locator("#canvas").scroll_into_view_if_needed()
    check("balanced" in user.text("#sides") and "path-tracing" in user.text("#sides"), "the sides are not named")
    for mode in ["signed", "relative", "flip"]:
        user.changes(mode, lambda: page.click(f"#thumbs [data-mode='{mode}']"))
        check(page.locator("#scale .ticks span").count() == 5, f"{mode} has no legend")
    user.changes("false colour", lambda: page.select_option("#mode", "luminance"))
    user.changes("the picture", lambda: page.select_option("#mode", "picture"))
    user.changes("the right side", lambda: page.select_option("#right", label="Reference"))
    user.changes("the exposure", lambda: user.slide("#exposure", -3))
    user.changes("the divider", lambda: user.slide("#split", 200))
    box = page.locator("#canvas").bounding_box()
    middle = (box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    user.changes("the wheel", lambda: (page.mouse.move(*middle), page.mouse.wheel(0, -300), page.wait_for_timeout(100)))

    def drag(start, end):
        page.mouse.move(*start)
        page.mouse.down()
        page.mouse.move(*end, steps=3)
        page.mouse.up()

    user.changes("dragging", lambda: drag(middle, (middle[0] + 60, middle[1] + 20)))
    divider = (box["x"] + 0.2 * box["width"], middle[1])
    user.changes("dragging the divider", lambda: drag(divider, middle))
    check(abs(int(page.input_value("#split")) - 500) < 20, "the divider was not dragged to the middle")
    user.changes("the button +", lambda: page.click("#zoom-in"))
    user.changes("the whole picture", lambda: page.click("#zoom-reset"))
    page.focus("#canvas")
    for key in ["+", "ArrowRight", "ArrowDown", "0", "+", "-", "[", "]", ",", ".", "m"]:
        user.changes(f"the key {key}", lambda: page.keyboard.press(key))
    page.mouse.move(*middle)
    check("radiance" in user.text("#pixel"), "the values of a pixel are not shown")


def colours_change(user):
    page = user.page
    before = page.evaluate(BACK)
    page.click("#theme")
    check(page.evaluate(BACK) != before, "the button does not change the colours")
    page.click("#theme")
    check(page.evaluate(BACK) == before, "the button does not change the colours back")


def plots_are_complete(user):
    page = user.page
    for selector, count in [("#frames .series", 3), ("#spectrum .series", 3), ("#noise tbody tr", 3), ("#passes .segment", 24)]:
        check(page.locator(selector).count() == count, f"{selector}: {page.locator(selector).count()} instead of {count}")
    check(page.locator("#passes-legend li").count() == 8, "the legend of passes is not complete")


def nothing_is_too_wide(user):
    widths = user.page.evaluate("[document.documentElement.scrollWidth, innerWidth]")
    check(widths[0] <= widths[1], f"the page is {widths[0]} pixels wide in a window of {widths[1]}")


def letters_do_not_overlap(user):
    overlapping = user.page.evaluate("""() => [...document.querySelectorAll("svg")].flatMap((svg) => {
        const boxes = [...svg.querySelectorAll(".bubble-text")].map((text) => text.getBoundingClientRect());
        return boxes.filter((a, i) => boxes.some((b, k) => k < i && a.left < b.right && b.left < a.right
            && a.top < b.bottom && b.top < a.bottom));
    }).length""")
    check(overlapping == 0, f"{overlapping} letters overlap")


def text_has_contrast(user):
    """Checks all texts against the background that they stand on, by the contrast of WCAG 2."""
    poor = user.page.evaluate("""() => {
        const canvas = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
        const channels = (colour) => {
            canvas.clearRect(0, 0, 1, 1);
            canvas.fillStyle = colour;
            canvas.fillRect(0, 0, 1, 1);
            return [...canvas.getImageData(0, 0, 1, 1).data];
        };
        const light = (colour) => {
            const [r, g, b] = channels(colour).map((v) => (v <= 10 ? v / 3294.6 : ((v / 255 + 0.055) / 1.055) ** 2.4));
            return 0.2126 * r + 0.7152 * g + 0.0722 * b;
        };
        const back = (element) => {
            for (let e = element; e; e = e.parentElement) {
                const colour = getComputedStyle(e).backgroundColor;
                if (channels(colour)[3] === 255) return colour;
            }
            return "white";
        };
        const hasText = (e) => [...e.childNodes].some((n) => n.nodeType === 3 && n.textContent.trim()) && e.getClientRects().length;
        return [...document.querySelectorAll("body *:not(script):not(option):not(title)")].filter(hasText).filter((e) => {
            const style = getComputedStyle(e);
            const own = light(e instanceof SVGElement ? style.fill : style.color);
            const bubble = e.classList.contains("bubble-text") ? getComputedStyle(e.previousSibling).fill : back(e);
            const [a, b] = [own, light(bubble)].sort((x, y) => y - x);
            return (a + 0.05) / (b + 0.05) < 4.5;
        }).map((e) => `${e.tagName} ${e.textContent.trim().slice(0, 30)}`);
    }""")
    check(not poor, f"texts with little contrast: {poor}")


def print_is_complete(user):
    user.page.click("#theme")
    user.page.emulate_media(media="print")
    check(user.page.evaluate(BACK) == "rgb(255, 255, 255)", "paper is not white")
    check(not user.page.is_visible("#theme") and not user.page.is_visible("#exposure"), "controls are printed")
    for selector in ["#answer", "#command", "#scatter svg", "#canvas", "#passes svg", "#spectrum svg"]:
        check(user.page.is_visible(selector), f"{selector} is not printed")
    pages = user.page.pdf(format="A4").count(b"/Type /Page\n")
    check(2 <= pages <= 12, f"the page prints on {pages} sheets")
    user.page.emulate_media(media="screen")


def take_pictures(user, name):
    FOLDER.mkdir(parents=True, exist_ok=True)
    user.page.screenshot(path=FOLDER / f"{name}-first-screen.png")
    for section in user.page.query_selector_all("section"):
        section.screenshot(path=FOLDER / f"{name}-{section.get_attribute('aria-labelledby').removesuffix('-title')}.png")


with sync_playwright() as playwright:
    chromium = playwright.chromium.launch(executable_path=os.environ["HEADWATER_BROWSER"] or None, args=["--no-sandbox"])
    for scheme in ["light", "dark"]:
        for size, width in WIDTHS.items():
            user = User(chromium, width, scheme)
            if FOLDER:
                take_pictures(user, f"{scheme}-{size}")
            nothing_is_too_wide(user)
            text_has_contrast(user)
            letters_do_not_overlap(user)
            user.close()
    if FOLDER:
        raise SystemExit
    user = User(chromium, WIDTHS["wide"])
    for step in [
        answer_comes_first,
        points_are_chosen,
        pictures_are_compared,
        plots_are_complete,
        colours_change,
        print_is_complete,
    ]:
        step(user)
    user.close()
    chromium.close()
