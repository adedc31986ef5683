"""A student in front of JupyterLab or JupyterLite: run by an environment that has Playwright, for each notebook named.

`python jupyterlab_page.py ADDRESS SAVED CHROMIUM PICTURES NOTEBOOK …` opens each, has all cells run from the menu,
saves it, takes a picture of all of it, and prints what the browser shows of every cell. `{name}` in ADDRESS stands for
the notebook. A browser that keeps notebooks to itself is made to download each into the folder SAVED; a server has
them, and SAVED is empty.
"""

import json
import sys
from typing import Any

from playwright.sync_api import Page, sync_playwright  # type: ignore[import-not-found, unused-ignore]

PATIENCE = 300_000
"""The time limit for a notebook in milliseconds."""
WINDOW = {"width": 1280, "height": 900}
TALLEST = 16_000
"""The size of a picture in pixels."""
IDLE = r"text=/(ipykernel|Pyodide)\) \| Idle/"
DONE = r"""() => [...document.querySelectorAll('.jp-Notebook .jp-CodeCell .jp-InputPrompt')].every(
    prompt => prompt.textContent === '' || /\[\d+\]/.test(prompt.textContent))"""
"""Every cell has a number; a folded one has no prompt."""
SETTLED = """() => !document.querySelector('.jp-Notebook .jp-MarkdownCell .jp-mod-placeholder')
    && [...document.querySelectorAll('.jp-Notebook img')].every(image => image.complete)"""
CELLS = """() => [...document.querySelectorAll('.jp-Notebook .jp-Cell')].map(cell => {
    const shown = cell.querySelector('.jp-RenderedMarkdown'), all = what => [...cell.querySelectorAll(what)];
    return {
        words: shown ? shown.innerText : '',
        images: all('img').map(image => image.naturalWidth * image.clientWidth),
        formulas: all('mjx-container').filter(one => one.getBoundingClientRect().width > 0).length,
        broken: all('mjx-merror, [data-mjx-error]').length,
        maths: all('.jp-OutputArea math').filter(one => one.getBoundingClientRect().width > 0).length,
        rows: all('table tr').length,
        wide: shown ? shown.scrollWidth - shown.clientWidth : 0,
        output: all('.jp-OutputArea-output').map(output => output.innerText).join(''),
        errors: all('.jp-OutputArea-output[data-mime-type*="stderr"], .jp-OutputArea-output[data-mime-type*="error"]')
            .length,
    };
})"""
HEIGHT = """() => Math.max(...[...document.querySelectorAll('.jp-WindowedPanel-outer')].map(one => one.scrollHeight))"""


def open_and_run(page: Page, address: str, saved: str, name: str, picture: str) -> Any:
    """Return what is shown of every cell when all have run."""
    page.set_viewport_size(WINDOW)
    page.goto(address.replace("{name}", name))
    page.wait_for_selector(IDLE, timeout=PATIENCE)
    page.locator(".lm-MenuBar-item", has_text="Run").click()
    page.locator(".lm-Menu-item", has_text="Run All Cells").first.click()
    page.wait_for_function(DONE, timeout=PATIENCE)
    page.wait_for_function(SETTLED, timeout=PATIENCE)
    page.keyboard.press("Control+s")
    page.wait_for_timeout(3000)
    if saved:
        download(page, f"{saved}/{name}")
    shown = page.evaluate(CELLS)
    page.set_viewport_size({**WINDOW, "height": min(TALLEST, page.evaluate(HEIGHT) + 150)})
    page.evaluate(TO_THE_TOP)
    page.wait_for_timeout(5000)
    page.screenshot(path=picture)
    page.set_viewport_size(WINDOW)
    return shown


def download(page: Page, path: str) -> None:
    """Download the open notebook from the list of files, which works in all versions."""
    with page.expect_download() as given:
        page.locator(".jp-DirListing-item", has_text=path.rpartition("/")[2]).click(button="right")
        page.locator(".lm-Menu-item[data-command='filebrowser:download']").click()
    given.value.save_as(path)


TO_THE_TOP = """() => document.querySelectorAll('.jp-WindowedPanel-outer').forEach(one => { one.scrollTop = 0; })"""


def main(address: str, saved: str, chromium: str, pictures: str, *names: str) -> None:
    """Print what is shown of each notebook."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        shown = []
        for name in names:
            page = browser.new_page()  # which knows of no notebook that was opened before
            shown.append(open_and_run(page, address, saved, name, f"{pictures}/{name.replace('/', '-')}.png"))
            page.context.close()
        browser.close()
    print(json.dumps(shown))


if __name__ == "__main__":
    main(*sys.argv[1:])
