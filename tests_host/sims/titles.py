"""The titles of a page's controls: JavaScript that returns the controls without a sentence."""

WITHOUT = """
return [...document.querySelectorAll("button, input:not([type=hidden]), select, textarea, summary, canvas, a[href], [tabindex]")]
  .filter((e) => !e.title).map((e) => e.outerHTML.slice(0, 200));
"""
