"""Packages: the facade `lensbench/`, and the folders of code beside it under the same name."""

from setuptools import find_packages, setup

CODE = ("core", "lenses", "shaders", "app")
setup(packages=["lensbench", *(f"lensbench.{name}" for name in find_packages() if name.split(".")[0] in CODE)],
      package_dir={"lensbench": "lensbench", **{f"lensbench.{name}": name for name in CODE}})
