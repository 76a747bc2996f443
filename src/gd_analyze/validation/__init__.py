"""A verdict over motions: a model held against exact and measured torques, and against a box of states."""

from gd_analyze.validation.along import ValidatedMotion as ValidatedMotion
from gd_analyze.validation.beside_measured import BesideMeasured as BesideMeasured
from gd_analyze.validation.box_exits import BoxExit as BoxExit
from gd_analyze.validation.box_exits import box_exits as box_exits
from gd_analyze.validation.junit import junit_xml as junit_xml
from gd_analyze.validation.validate import PROMISE as PROMISE
from gd_analyze.validation.validate import Validation as Validation
from gd_analyze.validation.validate import validate as validate
