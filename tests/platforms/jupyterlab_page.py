"""Run notebooks in JupyterLab as a student does; needs an environment with Playwright.

`python jupyterlab_page.py ADDRESS CHROMIUM PICTURES NOTEBOOK …` opens each notebook, runs all cells from the
menu, saves it, takes a picture of the whole notebook, and prints what the browser displays of every cell. `{name}` in
ADDRESS stands for the notebook.
"""

import json
import sys
from typing import Any

from playwright.sync_api import Page, sync_playwright  # type: ignore[import-not-found, unused-ignore]

PATIENCE = 300_000
"""Milliseconds that a notebook may run."""
WINDOW = {"width": 1280, "height": 900}
TALLEST = 16_000
"""Largest height of a picture in pixels."""
IDLE = r"text=/ipykernel\) \| Idle/"
DONE = r"""() => [...document.querySelectorAll('.jp-Notebook .jp-CodeCell .jp-InputPrompt')].every(
    prompt => prompt.textContent === '' || /\[\d+\]/.test(prompt.textContent))
    && [...document.querySelectorAll('.jp-Notebook .jp-CodeCell')].at(-1).querySelector('.jp-OutputArea-output')"""
"""Every code cell has a number in its prompt; a folded one, such as the last one, has no prompt, but an output."""
SETTLED = """() => !document.querySelector('.jp-Notebook .jp-MarkdownCell .jp-mod-placeholder')
    && [...document.querySelectorAll('.jp-Notebook img')].every(image => image.complete)"""
CELLS = """() => [...document.querySelectorAll('.jp-Notebook .jp-Cell')].map(cell => {
    const shown = cell.querySelector('.jp-RenderedMarkdown'), all = selector => [...cell.querySelectorAll(selector)];
    return {
        words: shown ? shown.innerText : '',
        images: all('img').map(image => image.naturalWidth * image.clientWidth),
        formulas: all('mjx-container').filter(element => element.getBoundingClientRect().width > 0).length,
        broken: all('mjx-merror, [data-mjx-error]').length,
        maths: all('.jp-OutputArea math').filter(element => element.getBoundingClientRect().width > 0).length,
        rows: all('table tr').length,
        wide: shown ? shown.scrollWidth - shown.clientWidth : 0,
        output: all('.jp-OutputArea-output').map(output => output.innerText).join(''),
        errors: all('.jp-OutputArea-output[data-mime-type*="stderr"], .jp-OutputArea-output[data-mime-type*="error"]')
            .length,
    };
})"""
HEIGHT = (
    """() => Math.max(...[...document.querySelectorAll('.jp-WindowedPanel-outer')].map(panel => panel.scrollHeight))"""
)


def open_and_run(page: Page, address: str, name: str, picture: str) -> Any:
    """Open a notebook, run all cells, save it, and return what the browser displays of every cell."""
    page.set_viewport_size(WINDOW)
    page.goto(address.replace("{name}", name))
    page.wait_for_selector(IDLE, timeout=PATIENCE)
    page.locator(".lm-MenuBar-item", has_text="Run").click()
    page.locator(".lm-Menu-item", has_text="Run All Cells").first.click()
    page.wait_for_function(DONE, timeout=PATIENCE)
    page.wait_for_selector(IDLE, timeout=PATIENCE)
    page.wait_for_function(SETTLED, timeout=PATIENCE)
    page.keyboard.press("Control+s")
    page.wait_for_timeout(3000)
    cells = page.evaluate(CELLS)
    page.set_viewport_size({**WINDOW, "height": min(TALLEST, page.evaluate(HEIGHT) + 150)})
    page.evaluate(SCROLL_TO_TOP)
    page.wait_for_timeout(5000)
    page.screenshot(path=picture)
    page.set_viewport_size(WINDOW)
    return cells


SCROLL_TO_TOP = (
    """() => document.querySelectorAll('.jp-WindowedPanel-outer').forEach(panel => { panel.scrollTop = 0; })"""
)


def main(address: str, chromium: str, pictures: str, *names: str) -> None:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        displayed = []
        for name in names:
            page = browser.new_page()  # a new context: no notebook is open in it
            displayed.append(open_and_run(page, address, name, f"{pictures}/{name.replace('/', '-')}.png"))
            page.context.close()
        browser.close()
    print(json.dumps(displayed))


if __name__ == "__main__":
    main(*sys.argv[1:])
