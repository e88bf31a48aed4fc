"""Runs on the board: prints what it has. `uf2 CHIP STAMP VERSION` is Passo's UF2, `micropython VERSION` another interpreter; then where
in the flash the file system begins, and the names in it."""

import os
import sys

try:
    image = __import__("passo_image")
    print("uf2", image.CHIP, image.STAMP, image.VERSION)
except ImportError:
    print(sys.implementation.name, ".".join([str(part) for part in sys.implementation[1][:3]]))
try:
    print(__import__("uctypes").addressof(__import__("rp2").Flash()) - 0x10000000)
except ImportError:
    print(-1)
print(" ".join(os.listdir()))
