"""Headless Chromium for the tests of pages: everything it logs and asks for is kept."""

import base64
import json
import time

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys

ZONE = "Europe/Berlin"


class Browser:
    """One browser, one page."""

    def __init__(self, chromium, driver, patience=1.0):
        self.patience = patience
        options = Options()
        options.binary_location = chromium
        for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--window-size=1400,1000"):
            options.add_argument(argument)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=Service(driver))
        self.driver.execute_cdp_cmd("Emulation.setTimezoneOverride", {"timezoneId": ZONE})
        self.requests, self.console = [], []
        self.look(1400, "light")

    def close(self):
        self.driver.quit()

    def open(self, url):
        """A fresh page: nothing stored."""
        self.driver.get("about:blank")
        origin = "/".join(url.split("/")[:3])
        clear = {"origin": origin, "storageTypes": "all"}
        self.driver.execute_cdp_cmd("Storage.clearDataForOrigin", clear)
        self.driver.get(url)
        self.js("sessionStorage.clear(); localStorage.clear()")
        self.driver.get(url)

    def look(self, width, scheme, height=1000, ratio=1):
        """The size of the window and the colours that the reader prefers."""
        size = {"width": width, "height": height, "deviceScaleFactor": ratio, "mobile": width < 600}
        self.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", size)
        features = [{"name": "prefers-color-scheme", "value": scheme}]
        self.driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})

    def shot(self, file):
        """What is in the window, as a PNG."""
        shot = self.driver.execute_cdp_cmd("Page.captureScreenshot", {"format": "png"})
        file.write_bytes(base64.b64decode(shot["data"]))

    def js(self, code, *arguments):
        return self.driver.execute_script(code, *arguments)

    def all(self, selector):
        return self.driver.find_elements(By.CSS_SELECTOR, selector)

    def one(self, selector):
        return self.driver.find_element(By.CSS_SELECTOR, selector)

    def whole(self, file):
        """All of the page, as a PNG, at the width that it has."""
        size = self.driver.execute_cdp_cmd("Page.getLayoutMetrics", {})["cssContentSize"]
        clip = {"x": 0, "y": 0, "width": size["width"], "height": min(size["height"], 12000), "scale": 1}
        shot = self.driver.execute_cdp_cmd(
            "Page.captureScreenshot", {"format": "png", "captureBeyondViewport": True, "clip": clip}
        )
        file.write_bytes(base64.b64decode(shot["data"]))

    def click(self, element):
        """A click in the middle of the window, where nothing lies over it."""
        self.js("arguments[0].scrollIntoView({ block: 'center' })", element)
        element.click()

    def text(self, selector):
        return self.js("return document.querySelector(arguments[0])?.textContent ?? ''", selector)

    def shown(self, selector):
        """Whether something that the selector names can be seen."""
        return any(element.is_displayed() for element in self.all(selector))

    def until(self, what, holds, seconds=5.0):
        """Waits until `holds()`; gives the seconds that it took."""
        seconds *= self.patience
        began = time.monotonic()
        while not (found := holds()):
            waited = time.monotonic() - began
            assert waited < seconds, f"{what}: not within {seconds} s, found {found!r}"
            time.sleep(0.03)
        return time.monotonic() - began

    def keys(self, *keys):
        """Keys to whatever has the focus."""
        ActionChains(self.driver).send_keys(*keys).perform()

    def focus(self):
        """What has the focus: its label or text."""
        return self.js(
            "const own = document.activeElement;"
            "return own.getAttribute('aria-label') || own.name || own.id || own.textContent.trim()"
        )

    def tab_to(self, wanted, most=200):
        """Tab until the focus is on what is called `wanted`."""
        for _ in range(most):
            if self.focus() == wanted:
                return
            self.keys(Keys.TAB)
        raise AssertionError(f"Tab did not reach {wanted!r} in {most} steps; it is on {self.focus()!r}")

    def collect(self):
        """Takes what was logged and asked for since the last call."""
        self.console += [entry["message"] for entry in self.driver.get_log("browser")]
        for entry in self.driver.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"] == "Network.requestWillBeSent":
                self.requests.append(message["params"]["request"]["url"])
            if message["method"] == "Network.webSocketCreated":
                self.requests.append(message["params"]["url"])

    def assert_quiet(self, but=()):
        """Nothing was logged, other than what holds one of the texts `but`."""
        self.collect()
        loud = [text for text in self.console if not any(own in text for own in but)]
        self.console.clear()
        assert loud == [], f"the console says {loud}"
