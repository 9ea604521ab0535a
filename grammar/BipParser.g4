// The sentences of BIP, both notations in one grammar. No actions. It accepts more than the language: parts of a
// transition in any order, items of an atom in a compound, `=` in any expression, statements without `;`. The conversion
// (compiler/parse/convert_*.cpp) says what does not belong, in the user's words; a grammar could only say "no".
// Nearly every decision needs one token: the pass over the token list marks the words that begin declarations.
parser grammar BipParser;

// Nodes are read through a base class of our own, which is only faster than ANTLR's.
options { tokenVocab = BipLexer; contextSuperClass = TreeNode; }
@parser::preinclude { #include "compiler/parse/tree_node.hpp" }

file: (package | decl)* EOF;
package: annotation* PACKAGE path use* decl* END;
use: USE path;
rootSpec: expr EOF;

decl: annotation* (constData | externType | externFunction | externOperator | functionDecl | portType | connectorType | atomType
  | compoundType | component);

// ---- data and the outside -----------------------------------------------------------------------------------------------
constData: (CONST DATA | DATA CONST) typeName var (COMMA var)*;
externType: EXTERN_DECL DATA TYPE (id | NATIVE) (REFINE typeName (COMMA typeName)*)? (AS STRING)?;
externFunction: EXTERN_DECL FUNCTION (CONST? typeName)? id LPAREN (protoParam (COMMA protoParam)*)? RPAREN;
externOperator: EXTERN_DECL OPERATOR CONST? typeName operatorSign LPAREN protoParam (COMMA protoParam)? RPAREN;
functionDecl: FUNCTION typeName id LPAREN params? RPAREN ASSIGN expr;
operatorSign: OROR | ANDAND | PIPE | CARET | AMP | EQ | NE | LT | GT | LE | GE | PLUS | MINUS | STAR | SLASH | PERCENT | BANG
  | TILDE | ASSIGN;
protoParam: CONST? typeName id?;
typeName: path | NATIVE;
annotation: AT_SIGN id (LPAREN (annotationArg (COMMA annotationArg)*)? RPAREN)?;
annotationArg: id (ASSIGN (id | TRUE | FALSE | STRING | INT | FLOAT))? | INT | FLOAT;
params: param (COMMA param)*;
param: CONST? typeName id;
var: id (ASSIGN expr)?;
dataDecl: EXPORT? DATA CONST? typeName var (COMMA var)*;

// ---- types --------------------------------------------------------------------------------------------------------------
portType: PORT_DECL TYPE id LPAREN params? RPAREN;
connectorType: CONNECTOR_DECL TYPE id LPAREN params? RPAREN connectorPart* END;
atomType: ATOM TYPE id LPAREN params? RPAREN bodyItem* END;
compoundType: COMPOUND TYPE id LPAREN params? RPAREN bodyItem* END;
component: COMPONENT_DECL id (LPAREN params? RPAREN)? bodyItem* END;

bodyItem: annotation* (dataDecl | portDecl | compoundExport | clockDecl | places | initial | finals | transition | priority
  | invariant | behavior | contains | componentDecl | connectorDecl | inlineConnector | propertyDecl | forItems);

// ---- connectors -----------------------------------------------------------------------------------------------------------
connectorPart: annotation* (dataDecl | connectorExport | define | clause);
connectorExport: EXPORT PORT typeName? id (LPAREN idList? RPAREN)?;
define: DEFINE portTerm (COMMA? portTerm)*;
portTerm: (portPath | family | (LPAREN | LBRACK | GROUP_OPEN) portTerm (COMMA? portTerm)* (RPAREN | RBRACK)) PRIME?;
portPath: portPart (DOT portPart)*;
portPart: id (LBRACK (expr | STAR) RBRACK)?;
clause: ON clausePort (COMMA? clausePort)* (provided | up | down | action)*;
clausePort: portPath | family;
// the paper's c₁, . . . , cₙ
family: id SUBSCRIPT COMMA ELLIPSIS COMMA id SUBSCRIPT;
up: UP block;
down: DOWN block;
provided: PROVIDED expr;

// ---- atoms ----------------------------------------------------------------------------------------------------------------
portDecl: (EXPORT | EXTERN)? PORT typeName? portItem (COMMA portItem)* (AS (id | STRING))? (REMEMBER | IGNORE | ERROR)?;
portItem: id (LPAREN idList? RPAREN)?;
clockDecl: CLOCK id (COMMA id)* (UNIT INT? id)?;
places: PLACE idList;
initial: INITIAL (to | clockReset | action | resume)*;
finals: FINAL idList;
behavior: BEHAVIOR (initial | annotation* transition | state)* END;
state: STATE id (annotation* transition)*;
transition: (ON id | INTERNAL) (from | to | provided | clockReset | urgency | action | resume)*;
clockReset: RESET idList;
from: FROM idList;
to: TO idList;
urgency: LAZY | DELAYABLE | EAGER;
resume: RESUME (LPAREN expr RPAREN)?;
priority: PRIORITY id index? prioritySide LT prioritySide provided?;
prioritySide: STAR (COLON STAR)? | path (COLON (STAR | path (COMMA path)*))?;
invariant: INVARIANT id ((AT | FROM) idList)? provided;

// ---- compounds --------------------------------------------------------------------------------------------------------------
contains: CONTAINS path instance (COMMA instance)*;
componentDecl: COMPONENT path instance (COMMA instance)*;
instance: id index? (LPAREN args? RPAREN)?;
args: expr (COMMA expr)*;
connectorDecl: CONNECTOR path binding (COMMA binding)*;
binding: id index? LPAREN boundPorts? RPAREN;
boundPorts: boundPort (COMMA boundPort)*;
boundPort: path | family | (LBRACK | GROUP_OPEN) boundPorts RBRACK;
inlineConnector: CONNECTOR binding connectorPart*;
compoundExport: EXPORT (PORT | DATA) path (COMMA path)* AS id;
propertyDecl: PROPERTY id index? PROPERTY_TEXT;
forItems: FOR id IN expr DOTDOT expr (bodyItem | LBRACE bodyItem* RBRACE);

// ---- statements ---------------------------------------------------------------------------------------------------------------
action: DO (block | simple SEMI?);
block: LBRACE stmts RBRACE;
stmts: (simple | ifStmt | SEMI)*;
simple: path (LPAREN args? RPAREN | PRIME? (ASSIGN | ARROW | LT MINUS) expr);
ifStmt: IF LPAREN expr RPAREN THEN stmts (ELSE_CHAIN IF LPAREN expr RPAREN THEN stmts)* (ELSE stmts)? FI;

// ---- expressions ----------------------------------------------------------------------------------------------------------------
expr:
  primary
  | (MINUS | PLUS | TILDE | BANG | NOT_WORD) expr
  | expr (STAR | SLASH | PERCENT) expr
  | expr (PLUS | MINUS) expr
  | expr (LT | GT | LE | GE) expr
  | expr (EQ | NE | ASSIGN) expr
  | expr AMP expr
  | expr CARET expr
  | expr PIPE expr
  | expr (ANDAND | AND_WORD) expr
  | expr (OROR | OR_WORD) expr;
primary: INT | FLOAT | STRING | TRUE | FALSE | REPORT | path (PRIME | LPAREN args? RPAREN)? | LPAREN expr RPAREN;

// ---- names ------------------------------------------------------------------------------------------------------------------------
path: pathPart (DOT pathPart)*;
pathPart: id index?;
index: (LBRACK | GROUP_OPEN) (expr | STAR) RBRACK;
idList: id (COMMA id)*;
id: ID | CLOCK | UNIT | INVARIANT | AT | FINAL | LAZY | DELAYABLE | EAGER | RESUME | REMEMBER | IGNORE | ERROR | AND_WORD | OR_WORD;
