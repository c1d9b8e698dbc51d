"""Controllers as data: conversion of a law in any form to the constants of the model `linear_controller`."""
