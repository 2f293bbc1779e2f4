# SPDX-License-Identifier: MIT
"""A page in a headless Chromium, controlled over its debugging pipe (the Chrome DevTools Protocol), or Firefox."""
import base64
import json
import os
import shutil
import socket
import subprocess
import time

import numpy as np

PATIENCE_S = 120


class Page:
    """The page that is open, in either browser: what a person does with it, and what it shows. Elements are named by ids."""

    def wait(self, condition):
        since = time.monotonic()
        while not self.evaluate(condition):
            if time.monotonic() - since > PATIENCE_S:
                raise RuntimeError(f"waited for {condition}")
            time.sleep(0.05)

    def settle(self):
        """Waits until the page shows the picture that was asked for."""
        self.wait("element('shown').getAttribute('aria-busy') !== 'true'")
        self.evaluate("new Promise(then => requestAnimationFrame(() => requestAnimationFrame(then)))")

    def text(self, element):
        return self.evaluate(f"element({element!r}).textContent")

    def message(self):
        return self.evaluate("element('message').hidden ? '' : element('message').textContent")

    def press(self, element):
        self.evaluate(f"element({element!r}).click()")

    def click(self, x, y):
        self.drag([(x, y)])

    def choose(self, menu, name):
        """Chooses an option of a menu, by the first word of its text or by its value. Browsers draw menus outside of the page,
        where no event can be sent to."""
        self.evaluate(f"""(() => {{
            const options = [...element({menu!r}).options], name = {name!r};
            const option = options.find(({{text}}) => text.split(" ")[0] === name) || options.find(({{value}}) => value === name);
            element({menu!r}).value = option.value;
        }})()""")
        self.tell(menu)

    def put(self, field, value):
        """Gives a field or a slider a value."""
        self.evaluate(f"element({field!r}).value = {str(value)!r}")
        self.tell(field)

    def tick(self, box, on):
        self.evaluate(f"element({box!r}).checked === {str(on).lower()} || element({box!r}).click()")
        self.settle()

    def see_by(self, options):
        """Sets the menus of the eye as options of develop say."""
        chosen = dict(option.lstrip("-").split("=") for option in options)
        adaptation, _, luminance = chosen.get("adaptation", "none").partition(":")
        self.choose("detector", chosen.get("detector", "cie1931"))
        self.choose("adaptation", adaptation)
        self.choose("display", chosen.get("display", "srgb"))
        self.put("luminance", luminance)
        self.tick("auto", chosen.get("exposure") == "auto")
        if chosen.get("exposure") != "auto":
            self.put("exposure", chosen.get("exposure", 1))

    def tool(self, name):
        """Chooses what a drag does."""
        self.evaluate(f"document.querySelector('#drags [value={name}], #pointing [value={name}]').click()")

    def tell(self, element):
        for kind in "input", "change":
            self.evaluate(f"element({element!r}).dispatchEvent(new Event({kind!r}, {{bubbles: true}}))")
        self.settle()

    def at(self, x, y):
        """The place in the window of a point of the picture. Centres of pixels end in 0.5."""
        self.evaluate("canvas.scrollIntoView({block: 'center'})")
        left, top, length = self.evaluate(
            "(() => { const b = canvas.getBoundingClientRect(); return [b.left, b.top, b.width / shape.width]; })()")
        return left + x * length, top + y * length

    def pixels(self):
        """Red, green, blue and alpha of the picture that was asked for [y, x, channel]."""
        self.settle()
        return self.painted()

    def painted(self):
        """Red, green, blue and alpha of the picture that is shown."""
        width, height, data = self.evaluate("""(() => {
            const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d", {willReadFrequently: true});
            copy.drawImage(canvas, 0, 0);
            let bytes = "";
            for (const byte of copy.getImageData(0, 0, canvas.width, canvas.height).data) bytes += String.fromCharCode(byte);
            return [canvas.width, canvas.height, btoa(bytes)];
        })()""")
        return np.frombuffer(base64.b64decode(data), np.uint8).reshape(height, width, 4)

    def download(self, button, name):
        """Presses a button, and returns the path of the file that the page then saves."""
        path = os.path.join(self.downloads, name)
        if os.path.exists(path):
            os.remove(path)
        self.press(button)
        since, size = time.monotonic(), 0
        while size == 0 or size != os.path.getsize(path):
            if time.monotonic() - since > PATIENCE_S:
                raise RuntimeError(f"{name} was not saved")
            size = os.path.getsize(path) if os.path.exists(path) else 0
            time.sleep(0.1)
        return path


class Browser(Page):
    """`complaints` collects the page's errors, `requests` the addresses that it requests. `gpu`: options that choose a GPU; without,
    there is none. `before` is a script that runs before those of each page."""

    def __init__(self, folder, gpu=("--disable-gpu",), before=""):
        self.complaints, self.requests, self.number, self.session = [], [], 0, None
        shutil.rmtree(folder, ignore_errors=True)
        os.makedirs(folder)
        self.downloads = os.path.abspath(folder)
        (their_in, self.to), (self.back, their_out) = os.pipe(), os.pipe()
        self.process = subprocess.Popen(
            ["chromium", "--headless=new", "--no-sandbox", *gpu, "--no-first-run",
             "--remote-debugging-pipe", f"--user-data-dir={self.downloads}/profile"],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            close_fds=False, preexec_fn=lambda: self.give_pipes(their_in, their_out))
        os.close(their_in)
        os.close(their_out)
        self.buffer = b""
        target = self.send("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.send(domain + ".enable")
        self.send("Page.addScriptToEvaluateOnNewDocument", source=before)
        self.send("Browser.setDownloadBehavior", behavior="allow", downloadPath=self.downloads)

    @staticmethod
    def give_pipes(their_in, their_out):
        """Chromium reads commands from descriptor 3 and answers to 4."""
        spare_in, spare_out = os.dup2(their_in, 100), os.dup2(their_out, 101)
        os.dup2(spare_in, 3)
        os.dup2(spare_out, 4)

    def receive(self):
        while b"\0" not in self.buffer:
            read = os.read(self.back, 1 << 20)
            if not read:
                raise RuntimeError("the browser is gone")
            self.buffer += read
        message, self.buffer = self.buffer.split(b"\0", 1)
        return json.loads(message)

    def note(self, message):
        method, what = message.get("method"), message.get("params", {})
        if method == "Runtime.exceptionThrown":
            self.complaints.append(str(what["exceptionDetails"]))
        elif method == "Runtime.consoleAPICalled":
            self.complaints.append(str(what["args"]))
        elif method == "Log.entryAdded":
            self.complaints.append(str(what["entry"]))
        elif method == "Network.requestWillBeSent":
            self.requests.append(what["request"]["url"])

    def send(self, method, **params):
        self.number += 1
        message = {"id": self.number, "method": method, "params": params}
        if self.session:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self.receive()
            if answer.get("id") != self.number:
                self.note(answer)
            elif "error" in answer:
                raise RuntimeError(f"{method}: {answer['error']}")
            else:
                return answer["result"]

    def evaluate(self, expression):
        """Returns the value of a JavaScript expression; waits if it is a promise."""
        answer = self.send("Runtime.evaluate", expression=expression, awaitPromise=True, allowUnsafeEvalBlockedByCSP=False,
                           returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(f"{expression[:200]}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def size(self, width, height, scale=1):
        self.send("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=scale, mobile=False)

    def scheme(self, name):
        self.send("Emulation.setEmulatedMedia",
                  features=[{"name": "prefers-color-scheme", "value": name}])

    def open(self, path, fragment="", until="document.body?.dataset.ready === 'true'"):
        self.send("Page.navigate", url="about:blank")
        self.send("Page.navigate", url="file://" + os.path.abspath(path) + fragment)
        self.wait("location.href !== 'about:blank' && " + until)

    def pointer(self, kind, x, y, buttons):
        self.send("Input.dispatchMouseEvent", type=kind, x=x, y=y, buttons=buttons, clickCount=1,
                  button="none" if kind == "mouseMoved" and not buttons else "left")

    def drag(self, path):
        """Presses the mouse at the first place of a path, moves along it, and releases it."""
        self.pointer("mousePressed", *path[0], 1)
        for place in path[1:]:
            self.pointer("mouseMoved", *place, 1)
        self.pointer("mouseReleased", *path[-1], 0)

    def touch(self, *paths):
        """Lays a finger at the first place of each path, moves all of them together, and lifts them."""
        for kind, places in (("touchStart", [path[0] for path in paths]),
                             *(("touchMove", places) for places in zip(*paths)), ("touchEnd", [])):
            self.send("Input.dispatchTouchEvent", type=kind,
                      touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(places)])

    def wheel(self, x, y, by):
        self.send("Input.dispatchMouseEvent", type="mouseWheel", x=x, y=y, deltaX=0, deltaY=by)

    def type(self, text):
        for letter in text:
            self.send("Input.dispatchKeyEvent", type="keyDown", text=letter, key=letter)
            self.send("Input.dispatchKeyEvent", type="keyUp", key=letter)

    def enter(self):
        self.key("Enter")

    def drop(self, *paths):
        """Drops files onto the middle of the page."""
        data = {"items": [], "files": [os.path.abspath(path) for path in paths], "dragOperationsMask": 1}
        for kind in ("dragEnter", "dragOver", "drop"):
            self.send("Input.dispatchDragEvent", type=kind, x=300, y=300, data=data)

    KEYS = {"ArrowLeft": 37, "ArrowUp": 38, "ArrowRight": 39, "ArrowDown": 40, "Enter": 13,
            "Tab": 9, " ": 32}

    def key(self, key, shift=False):
        text = {"Enter": "\r", " ": " "}.get(key, "")
        for kind in ("keyDown", "keyUp"):
            self.send("Input.dispatchKeyEvent", type=kind, key=key, code=key,
                      windowsVirtualKeyCode=self.KEYS[key], modifiers=8 if shift else 0,
                      **({"text": text} if kind == "keyDown" and text else {}))

    def close(self):
        try:
            self.send("Browser.close")
        except RuntimeError:
            pass
        os.close(self.to)
        self.process.wait(timeout=PATIENCE_S)
        os.close(self.back)


class Firefox(Page):
    """A page in a headless Firefox, controlled over Marionette, its protocol of length:JSON messages. `screen`: an X server to draw on,
    by Mesa's llvmpipe, since a headless Firefox has no WebGL."""

    def __init__(self, folder, screen=None):
        shutil.rmtree(folder, ignore_errors=True)
        self.downloads = os.path.abspath(folder)
        profile = os.path.join(self.downloads, "profile")
        os.makedirs(profile)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            port = free.getsockname()[1]
        preferences = {"marionette.port": port, "browser.download.folderList": 2, "browser.download.dir": self.downloads,
                       "browser.helperApps.neverAsk.saveToDisk": "image/tiff,text/plain,text/csv,image/png",
                       "browser.download.useDownloadDir": True, "network.captive-portal-service.enabled": False,
                       "datareporting.policy.dataSubmissionEnabled": False, "app.update.enabled": False,
                       "browser.download.always_ask_before_handling_new_types": False,
                       "webgl.force-enabled": True, "gfx.x11-egl.force-enabled": True}
        with open(os.path.join(profile, "user.js"), "w", encoding="ascii") as file:
            file.writelines(f"user_pref({json.dumps(name)}, {json.dumps(value)});\n" for name, value in preferences.items())
        self.process = subprocess.Popen(
            ["firefox-esr", *([] if screen else ["--headless"]), "--no-remote", "--marionette", "--profile", profile],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
            env={**os.environ, "HOME": self.downloads, "MOZ_DISABLE_CONTENT_SANDBOX": "1",
                 **({"DISPLAY": screen, "LIBGL_ALWAYS_SOFTWARE": "1"} if screen else {})})
        self.socket, self.buffer, self.number = self.connect(port), b"", 0
        self.receive()  # its greeting
        self.send("WebDriver:NewSession")
        self.send("WebDriver:SetTimeouts", script=1000 * PATIENCE_S, pageLoad=1000 * PATIENCE_S)

    def connect(self, port):
        since = time.monotonic()
        while True:
            try:
                return socket.create_connection(("127.0.0.1", port), timeout=PATIENCE_S)
            except OSError:
                if time.monotonic() - since > PATIENCE_S or self.process.poll() is not None:
                    raise
                time.sleep(0.1)

    def more(self):
        read = self.socket.recv(1 << 20)
        if not read:
            raise RuntimeError("the browser is gone")
        self.buffer += read

    def receive(self):
        while b":" not in self.buffer:
            self.more()
        length, self.buffer = self.buffer.split(b":", 1)
        while len(self.buffer) < int(length):
            self.more()
        message, self.buffer = self.buffer[:int(length)], self.buffer[int(length):]
        return json.loads(message)

    def send(self, command, **parameters):
        self.number += 1
        message = json.dumps([0, self.number, command, parameters])
        self.socket.sendall(f"{len(message.encode())}:{message}".encode())
        while True:
            kind, number, error, result = self.receive()
            if kind == 1 and number == self.number:
                if error:
                    raise RuntimeError(f"{command}: {error}")
                return result

    def evaluate(self, expression):
        """Runs the expression as a script of the page, whose names no other script sees."""
        inner = (f"Promise.resolve().then(async () => ({expression})).then(value => JSON.stringify([value === undefined ? null : value]),"
                 "error => JSON.stringify([null, String(error)])).then(text => document.documentElement.dataset.answer = text);")
        script = ("const then = arguments[0], root = document.documentElement, script = document.createElement('script');"
                  "delete root.dataset.answer;"
                  "const look = () => root.dataset.answer === undefined ? setTimeout(look, 2) : then(root.dataset.answer);"
                  f"script.textContent = {json.dumps(inner)}; root.append(script); script.remove(); look();")
        value, *failure = json.loads(self.send("WebDriver:ExecuteAsyncScript", script=script, args=[])["value"])
        if failure:
            raise RuntimeError(f"{expression[:200]}: {failure[0]}")
        return value

    def act(self, *sources):
        self.send("WebDriver:PerformActions", actions=[
            {"type": kind, "id": f"{kind} {i}", **({"parameters": parameters} if parameters else {}), "actions": actions}
            for i, (kind, parameters, actions) in enumerate(sources)])
        self.send("WebDriver:ReleaseActions")

    @staticmethod
    def finger(kind, path):
        step = [{"type": "pointerMove", "x": round(x), "y": round(y), "duration": 15} for x, y in path]
        return ("pointer", {"pointerType": kind},
                [step[0], {"type": "pointerDown", "button": 0}, *step[1:], {"type": "pointerUp", "button": 0}])

    def drag(self, path):
        self.act(self.finger("mouse", path))

    def touch(self, *paths):
        self.act(*(self.finger("touch", path) for path in paths))

    def wheel(self, x, y, by):
        self.act(("wheel", None, [{"type": "scroll", "x": round(x), "y": round(y), "deltaX": 0, "deltaY": by}]))

    def type(self, text):
        self.act(("key", None, [{"type": kind, "value": letter} for letter in text for kind in ("keyDown", "keyUp")]))

    def enter(self):
        self.type("\ue007")

    def drop(self, *paths):
        """Opens files by the page's input: Marionette drops none, and adds to those of the time before."""
        self.evaluate("(() => { element('opened').value = ''; })()")
        found = self.send("WebDriver:FindElement", using="css selector", value="#opened")["value"]
        self.send("WebDriver:ElementSendKeys", id=list(found.values())[0], text="\n".join(map(os.path.abspath, paths)))

    def size(self, width, height):
        self.send("WebDriver:SetWindowRect", width=width, height=height)

    def open(self, path, fragment="", until="document.body?.dataset.ready === 'true'"):
        self.send("WebDriver:Navigate", url="about:blank")
        self.send("WebDriver:Navigate", url="file://" + os.path.abspath(path) + fragment)
        self.wait(until)

    def close(self):
        try:
            self.send("Marionette:Quit", flags=["eForceQuit"])
        except (RuntimeError, OSError):
            pass
        self.socket.close()
        self.process.wait(timeout=PATIENCE_S)
