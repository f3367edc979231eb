"""Writes the arrays of this folder with NumPy; the broken ones are cut or changed by hand."""
import numpy as np

angles = np.linspace(0, 2 * np.pi, 6, endpoint=False)
positions = np.stack([4 * np.cos(angles), 4 * np.sin(angles), np.zeros(6)], axis=1)
np.save("positions.npy", positions.astype(np.float32))
turned = np.zeros((6, 3, 4))
turned[:, 0, 0] = turned[:, 1, 1] = np.cos(angles)
turned[:, 1, 0] = np.sin(angles)
turned[:, 0, 1] = -np.sin(angles)
turned[:, 2, 2] = 1 + angles / 10
turned[:, :, 3] = 2 * positions
np.save("forest.npy", np.asfortranarray(turned.astype(">f8")))
np.save("heights.npy", np.arange(6, dtype=np.int16).reshape(2, 3))
np.save("flat.npy", np.zeros((3, 3, 4)))
np.save("nan.npy", np.where(np.arange(6).reshape(2, 3) == 4, np.nan, 1.0))
np.save("none.npy", np.zeros((0, 3)))
np.save("four_rows.npy", np.zeros((2, 4, 4)))
np.save("words.npy", np.array(["a", "b"]))
np.save("objects.npy", np.array([{}], dtype=object))
np.save("fields.npy", np.zeros(2, dtype=[("x", "<f8"), ("y", "<f8")]))
whole = open("positions.npy", "rb").read()
open("cut.npy", "wb").write(whole[:150])
open("header_only.npy", "wb").write(whole[:40])
open("lie.npy", "wb").write(whole.replace(b"'shape': (6, 3), }      ", b"'shape': (99999999, 3), "[:24]).replace(b"99999999, 3), ", b"99999999,3), }"))
open("not_numpy.npy", "wb").write(b"PK\x03\x04 this is an archive")
