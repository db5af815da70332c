# SPDX-License-Identifier: BSD-3-Clause
"""The library three.js, by which the page draws a scene in space; it becomes a part of the page."""

from pathlib import Path

PLACES = (Path("/usr/share/javascript/three/three.min.js"), Path("/usr/share/javascript/three/build/three.min.js"))
LICENCE = """/*
three.js: The MIT License

Copyright © 2010-2019 three.js authors

Permission is hereby granted, free of charge, to any person obtaining a copy of this software and associated
documentation files (the "Software"), to deal in the Software without restriction, including without limitation the
rights to use, copy, modify, merge, publish, distribute, sublicense, and/or sell copies of the Software, and to permit
persons to whom the Software is furnished to do so, subject to the following conditions:

The above copyright notice and this permission notice shall be included in all copies or substantial portions of the
Software.

THE SOFTWARE IS PROVIDED "AS IS", WITHOUT WARRANTY OF ANY KIND, EXPRESS OR IMPLIED, INCLUDING BUT NOT LIMITED TO THE
WARRANTIES OF MERCHANTABILITY, FITNESS FOR A PARTICULAR PURPOSE AND NONINFRINGEMENT. IN NO EVENT SHALL THE AUTHORS OR
COPYRIGHT HOLDERS BE LIABLE FOR ANY CLAIM, DAMAGES OR OTHER LIABILITY, WHETHER IN AN ACTION OF CONTRACT, TORT OR
OTHERWISE, ARISING FROM, OUT OF OR IN CONNECTION WITH THE SOFTWARE OR THE USE OR OTHER DEALINGS IN THE SOFTWARE.
*/
"""


def library() -> str | None:
    """A script element with the library and its licence; None where Debian's package libjs-three is not installed."""
    path = next((place for place in PLACES if place.is_file()), None)
    if path is None:
        return None
    text = path.read_text(encoding="utf-8")
    # neither may stand in a script element of a page
    text = text.replace("</script", "<\\/script").replace("<!--", "<\\!--")
    return f"<script>\n{LICENCE}{text}\n</script>"
