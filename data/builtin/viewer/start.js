/* Starts the page: a live one has start_live, and the page of a stack has the data of a stack. */
(typeof start_live === "function" ? start_live : element("stack") ? start_stack : start_still)().catch(error => {
  if (element("progress")) set_text("progress", "");
  show_message(`This browser cannot compute the picture (${error.message}). Browsers of 2023 and later can.`);
  throw error;
});
